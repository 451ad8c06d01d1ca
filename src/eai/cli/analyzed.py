"""What the analyses of records share: the records that a command is given, as tidy tables."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from eai.analysis.tidy import TableMaker, Tables
from eai.benchmarks.source import Source
from eai.cli.console import data_progress
from eai.cli.data import store
from eai.report.runs import read_runs

Records: TypeAlias = Annotated[
    list[Path], typer.Argument(help="Files of records, or folders with records.jsonl somewhere below.")
]


def tables_of(records: Iterable[Path], data: Path | None) -> Tables:
    """The tidy tables of all runs in files and folders.

    Args:
        records: the files and folders.
        data: the folder of the data set; the user's if None.

    Raises:
        InputError: there are no records, or one is unusable.
    """
    with data_progress() as report:
        maker = TableMaker(Source(store(data), report))
        for run in read_runs(records):
            maker.add(run.records)
    return maker.tables
