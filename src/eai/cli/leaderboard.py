"""``eai leaderboard``: runs as one table, best first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import FOUR
from eai.cli.console import counted, note, output, say
from eai.cli.options import AsJson, Wide
from eai.report.document import unnamed_remark
from eai.report.ranking import Ranking
from eai.report.rankings import rankings
from eai.report.run_summary import plain_runs, summary_of
from eai.report.table_specs import ColumnSpec, domain_title
from eai.report.writer import rankings_json
from eai.results.markdown import superscript
from eai.results.table import Table
from eai.results.terminal import print_table
from eai.scoring.runs import as_asked_in_paper, read_runs

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

    An ability that is none of the paper's has a table of its own.

    Example: eai leaderboard scores --paper
    """
    summaries = [summary_of(as_asked_in_paper(run) if paper else run) for run in read_runs(runs)]
    summaries.sort(key=lambda item: item.key.order)
    ranked = plain_runs(summaries)
    shown = {_OVERVIEW, *{item.key.ability.value for item in ranked}.difference(FOUR)}
    tables = [table for table in rankings(ranked, with_paper=paper) if table.name in shown]
    if as_json:
        print(rankings_json(tables), end="")
        return
    for table in tables:
        print_table(output(), _shown(table), wide=wide)
        for number in sorted({number for row in table.rows for number in row.notes}):
            say(f"{superscript((number,))} {table.notes[number - 1]}")
    if len(ranked) < len(summaries):
        left_out = counted(len(summaries) - len(ranked), "experiment")
        note(f"left out: {left_out}, which eai report shows apart")
    remark = unnamed_remark(ranked)
    if remark:
        note(remark)


def _shown(ranking: Ranking) -> Table:
    """A table with its protocol in the title, and abilities over its columns."""
    table = ranking.table()
    first = len(table.columns) - len(ranking.columns)
    headings = map(_heading, ranking.columns)
    columns = [
        replace(column, alone=text) for column, text in zip(table.described[first:], headings, strict=True)
    ]
    title = f"{domain_title(ranking.domain)}, protocol {ranking.protocol.value} (percent)"
    return replace(table, title=title, columns=(*table.columns[:first], *columns))


def _heading(column: ColumnSpec) -> str:
    label = column.label.lower() if column.label != "F1" else column.label
    return label if column.ability is None else f"{declaration_of(column.ability).short}\n{label}"
