"""``eai leaderboard``: runs as one table, best first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from eai.abilities.declaration import declaration_of
from eai.cli.console import counted, note, output, say
from eai.cli.options import AsJson, Wide
from eai.cli.table import Column, print_table
from eai.report.certainty import unnamed_remark
from eai.report.data_files import tables_json
from eai.report.markdown import superscript
from eai.report.row import Cell, Row, RowSource
from eai.report.run_summary import plain_runs, summary_of
from eai.report.runs import as_asked_in_paper, read_runs
from eai.report.table import Table
from eai.report.table_specs import ColumnSpec, domain_title
from eai.report.writer import make_tables

_OVERVIEW = "overview"


def leaderboard(
    runs: Annotated[
        list[Path], typer.Argument(help="Records, or folders with records.jsonl below.", metavar="RUNS")
    ],
    paper: Annotated[bool, typer.Option("--paper", help="Show the paper's models among the runs.")] = False,
    as_json: AsJson = False,
    wide: Wide = False,
) -> None:
    """Print the main results of runs, one table a domain and protocol, the best model first.

    Example: eai leaderboard scores --paper
    """
    summaries = [summary_of(as_asked_in_paper(run) if paper else run) for run in read_runs(runs)]
    summaries.sort(key=lambda item: item.key.order)
    ranked = plain_runs(summaries)
    tables = [table for table in make_tables(ranked, with_paper=paper) if table.name == _OVERVIEW]
    if as_json:
        print(tables_json(tables), end="")
        return
    for table in tables:
        _print(table, wide=wide)
        for number in sorted({number for row in table.rows for number in row.notes}):
            say(f"{superscript((number,))} {table.notes[number - 1]}")
    if len(ranked) < len(summaries):
        left_out = counted(len(summaries) - len(ranked), "experiment")
        note(f"left out: {left_out}, which eai report shows apart")
    remark = unnamed_remark(ranked)
    if remark:
        note(remark)


def _print(table: Table, *, wide: bool) -> None:
    title = f"{domain_title(table.domain)}, protocol {table.protocol.value} (percent)"
    ranks = Column("#", ["" if row.rank is None else str(row.rank) for row in table.rows])
    names = Column("model", [_name(row) for row in table.rows])
    answered = Column("answered", [row.answered or "-" for row in table.rows])
    columns = [
        Column(_heading(column), [_number(row.cells[place]) for row in table.rows])
        for place, column in enumerate(table.columns)
    ]
    print_table(output(), title, [ranks, names], [answered, *columns], wide=wide)


def _heading(column: ColumnSpec) -> str:
    label = column.label.lower() if column.label != "F1" else column.label
    return label if column.ability is None else f"{declaration_of(column.ability).short}\n{label}"


def _name(row: Row) -> Text:
    """The name with footnotes."""
    return Text(row.label + superscript(row.notes), style="" if row.source is RowSource.RUN else "dim")


def _number(cell: Cell) -> Text:
    if cell.percent is None:
        return Text("-")
    text = Text(f"{cell.percent:.1f}", style="bold" if cell.best else "")
    if cell.interval is not None:
        text.append(f"\n±{(cell.interval.high - cell.interval.low) / 2:.1f}", style="dim not bold")
    return text
