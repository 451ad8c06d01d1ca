"""``eai analyze all``: every analysis of the same records, which are read once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from eai.analysis.cofactors import cofactor_tables
from eai.analysis.error_leaves import error_tables
from eai.analysis.goal_atoms import goal_tables
from eai.analysis.item_flags import ItemFlags
from eai.analysis.items import item_tables
from eai.analysis.suites import Measure
from eai.benchmarks.source import Source
from eai.cli import analyze_cofactors, analyze_errors, analyze_goals, analyze_items
from eai.cli.analyzed import Plots, Records, tables_of, with_extra, write_analysis
from eai.cli.store import DataFolder, store


def everything(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the results, a folder an analysis.")],
    plots: Plots = True,
    data: DataFolder = None,
) -> None:
    """Write the analyses of cofactors, errors, goals and items, reading records once.

    Sensitivity is not among them: it takes a planner minutes a model.

    Example: eai analyze all scores --out analyses
    """
    tables = tables_of(records, data)
    with with_extra():
        found = cofactor_tables(tables)
        write_analysis("cofactors", found, analyze_cofactors.figures(found, Measure.SCORE), out, plots=plots)
        found = error_tables(tables.answers, tables.clauses)
        write_analysis("errors", found, analyze_errors.figures(found), out, plots=plots)
        found = goal_tables(tables.atoms)
        write_analysis("goals", found, analyze_goals.figures(found), out, plots=plots)
        found = item_tables(tables.answers, ItemFlags(Source(store(data))))
        write_analysis("items", found, analyze_items.figures(found), out, plots=plots)
