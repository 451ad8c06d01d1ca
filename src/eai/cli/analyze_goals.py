"""``eai analyze goals``: which goals models find, miss and make up."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.analyzed import Figures, Plots, Records, of_suite, say, tables_of, write_analysis
from eai.cli.options import AsJson
from eai.cli.store import DataFolder
from eai.results import plot_analyses
from eai.results.table import Table
from eai.studies.goals.analysis import goal_tables


def goals(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Goal interpretation by predicate: what is found, missed and made up, and where wrong goals come from.

    Example: eai analyze goals scores --out goals
    """
    found = goal_tables(tables_of(records, data).atoms)
    written = write_analysis("goals", found, figures(found), out, plots=plots)
    say(written, as_json=as_json)


def figures(found: list[Table]) -> Figures:
    """The plots of the analysis."""
    by_predicate, reasons = found[:2]
    for suite, rows in plot_analyses.rows_of(by_predicate).items():
        for score in ("precision", "recall"):
            yield of_suite(suite, score, plot_analyses.draw_names(rows, "predicate", score, score))
    for suite, rows in plot_analyses.rows_of(reasons).items():
        figure = plot_analyses.draw_matrix(rows, ("reason",), "share", "percent of wrong goals")
        yield of_suite(suite, "reasons", figure)
