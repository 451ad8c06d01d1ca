"""``eai analyze goals``: which goals models find, miss and make up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.analysis.goal_atoms import goal_tables
from eai.analysis.table import Table, write_tables
from eai.cli.analyzed import Figures, Plots, Records, draw_figures, say, tables_of
from eai.cli.store import DataFolder
from eai.report import plot_analyses


def goals(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    plots: Plots = True,
    data: DataFolder = None,
) -> None:
    """Goal interpretation by predicate: what is found, missed and made up, and where wrong goals come from.

    Example: eai analyze goals scores --out goals
    """
    found = goal_tables(tables_of(records, data).atoms)
    write_tables(out, "goals", found)
    drawn = draw_figures(figures(found), out) if plots else 0
    say(found, drawn, out)


def figures(found: list[Table]) -> Figures:
    """The plots of the analysis."""
    by_predicate, reasons = found[:2]
    for suite, rows in plot_analyses.rows_of(by_predicate).items():
        for score in ("precision", "recall"):
            yield f"{score}-{suite.file_name}", plot_analyses.draw_names(rows, "predicate", score, score)
    for suite, rows in plot_analyses.rows_of(reasons).items():
        figure = plot_analyses.draw_matrix(rows, ("reason",), "share", "percent of wrong goals")
        yield f"reasons-{suite.file_name}", figure
