"""``eai analyze all``: every analysis of the same records, which are read once."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from eai.cli import analyze_cofactors, analyze_errors, analyze_goals, analyze_items
from eai.cli.analyzed import (
    Explorer,
    Figures,
    Plots,
    Records,
    Written,
    address,
    say,
    tables_of,
    with_extra,
    write_analysis,
)
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.results.suites import Measure
from eai.results.table import Table
from eai.results.tidy import Tables
from eai.scoring.undisturbed import undisturbed
from eai.studies.cofactors.analysis import cofactor_tables
from eai.studies.errors.analysis import error_tables
from eai.studies.goals.analysis import goal_tables
from eai.studies.items.analysis import item_tables
from eai.studies.items.item_flags import ItemFlags
from eai.tasks.source import Source


def everything(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results, a folder an analysis.")],
    explorer: Explorer = None,
    plots: Plots = True,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write the analyses of cofactors, errors, goals and items, reading records once.

    Sensitivity is not among them: it takes a planner minutes a model.

    Example: eai analyze all scores --out analyses
    """
    made: list[Written] = []
    with undisturbed(), with_extra():
        known = ItemFlags(Source(store(data)))
        linked = address(explorer, out / "errors")
        for name, found, figures in _analyses(tables_of(records, data), known, linked):
            made.append(write_analysis(name, found, figures, out / name, plots=plots))
            if not as_json:
                say(made[-1], as_json=False)
    if as_json:
        say(*made, as_json=True)


def _analyses(
    tables: Tables, flags: ItemFlags, explorer: str | None
) -> Iterator[tuple[str, list[Table], Figures]]:
    """Each analysis by its name, with its tables and figures, made one after the other."""
    found = cofactor_tables(tables)
    yield "cofactors", found, analyze_cofactors.figures(found, Measure.SCORE)
    found = error_tables(tables.answers, tables.clauses, explorer=explorer)
    yield "errors", found, analyze_errors.figures(found)
    found = goal_tables(tables.atoms)
    yield "goals", found, analyze_goals.figures(found)
    found = item_tables(tables.answers, flags)
    yield "items", found, analyze_items.figures(found)
