"""``eai analyze items``: which tasks tell models apart, and which are odd."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.cli.analyzed import Figures, Plots, Records, of_suite, say, tables_of, with_extra, write_analysis
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.errors import InputError
from eai.results import plot_analyses
from eai.results.table import Table
from eai.studies.items import plots as plot_items
from eai.studies.items.analysis import FEWEST_MODELS, item_tables
from eai.studies.items.item_flags import ItemFlags
from eai.tasks.source import Source


def items(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results.")],
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Rate tasks by the answers of many models: difficulty, agreement with the others, and what is odd.

    Example: eai analyze items scores --out items
    """
    answers = tables_of(records, data).answers
    with with_extra():
        found = item_tables(answers, ItemFlags(Source(store(data))))
    if not found[0].rows:
        raise InputError(f"expected answers of at least {FEWEST_MODELS} models to one suite")
    written = write_analysis("items", found, figures(found), out, plots=plots)
    say(written, as_json=as_json)


def figures(found: list[Table]) -> Figures:
    """The plots of the analysis."""
    abilities = plot_analyses.rows_of(found[1])
    for suite, rows in plot_analyses.rows_of(found[3]).items():
        yield of_suite(suite, "items", plot_items.draw(rows, abilities[suite]))
