"""``eai analyze errors``: what goes wrong, and which precondition is overlooked."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.analyzed import (
    Explorer,
    Figures,
    Plots,
    Records,
    address,
    of_suite,
    say,
    tables_of,
    write_analysis,
)
from eai.cli.options import AsJson
from eai.cli.store import DataFolder
from eai.results import plot_analyses
from eai.results.table import Table
from eai.studies.errors import plots as plot_leaves
from eai.studies.errors.analysis import error_tables


def errors(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    examples: Annotated[int, typer.Option(min=0, help="How many answers to name of each kind.")] = 3,
    explorer: Explorer = None,
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Sort errors by the paper's taxonomy, and say which check failed how often.

    Example: eai analyze errors scores --out errors
    """
    tables = tables_of(records, data, features=False)
    found = error_tables(tables.answers, tables.clauses, examples=examples, explorer=address(explorer, out))
    written = write_analysis("errors", found, figures(found), out, plots=plots)
    say(written, as_json=as_json)


def figures(found: list[Table]) -> Figures:
    """The plots of the analysis."""
    leaves, why = found[:2]
    for suite, rows in plot_analyses.rows_of(leaves).items():
        yield of_suite(suite, "flow", plot_leaves.draw(rows))
        levels = ("stage", "kind", "detail")
        figure = plot_analyses.draw_matrix(rows, levels, "answers", "percent of answers")
        yield of_suite(suite, "leaves", figure)
    for suite, rows in plot_analyses.rows_of(why).items():
        figure = plot_analyses.draw_names(rows, "check", "share", "share of runtime errors")
        yield of_suite(suite, "why", figure)
