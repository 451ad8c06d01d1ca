"""``eai leaderboard``: runs as one table, best first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table as Grid
from rich.text import Text

from eai.abilities.declarations import DECLARATIONS
from eai.cli.console import errors, output
from eai.report.certainty import unnamed_remark
from eai.report.run_summary import summary_of
from eai.report.runs import as_asked_in_paper, read_runs
from eai.report.table import Cell, Row, Table
from eai.report.table_specs import ColumnSpec, domain_title
from eai.report.writer import make_tables

_OVERVIEW = "overview"


def leaderboard(
    runs: Annotated[
        list[Path], typer.Argument(help="Records, or folders with records.jsonl below.", metavar="RUNS...")
    ],
    paper: Annotated[bool, typer.Option("--paper", help="Show the paper's models among the runs.")] = False,
) -> None:
    """Print the main results of runs, one table a domain and protocol, the best model first.

    Example: eai leaderboard scores --paper
    """
    summaries = [summary_of(as_asked_in_paper(run) if paper else run) for run in read_runs(runs)]
    summaries.sort(key=lambda item: item.key.order)
    for table in make_tables(summaries, with_paper=paper):
        if table.name == _OVERVIEW:
            output().print(_grid(table))
    remark = unnamed_remark(summaries)
    if remark:
        errors().print(remark, markup=False, highlight=False)


def _grid(table: Table) -> Grid:
    title = f"{domain_title(table.domain)}, protocol {table.protocol.value} (percent)"
    grid = Grid(title=title, title_justify="left")
    grid.add_column("#", justify="right")
    grid.add_column("model", overflow="fold")
    for column in table.columns:
        grid.add_column(_heading(column), justify="right")
    for row in table.rows:
        grid.add_row("" if row.rank is None else str(row.rank), _model(row), *map(_number, row.cells))
    return grid


def _heading(column: ColumnSpec) -> str:
    label = column.label.lower() if column.label != "F1" else column.label
    return label if column.ability is None else f"{DECLARATIONS[column.ability].short}\n{label}"


def _model(row: Row) -> Text:
    return Text(f"{row.model} (paper)", style="dim") if row.from_paper else Text(row.model)


def _number(cell: Cell) -> Text:
    if cell.percent is None:
        return Text("-")
    text = Text(f"{cell.percent:.1f}", style="bold" if cell.best else "")
    if cell.interval is not None:
        text.append(f"\n±{(cell.interval.high - cell.interval.low) / 2:.1f}", style="dim not bold")
    return text
