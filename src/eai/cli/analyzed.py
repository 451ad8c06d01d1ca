"""What the analyses of records share: from the records that a command is given to tables and plots."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from eai.analysis.table import Table, write_tables
from eai.analysis.tidy import TableMaker, Tables
from eai.benchmarks.source import ErrataChoice, Source
from eai.cli.console import counted, data_progress, errors, output
from eai.cli.store import store
from eai.errors import EaiError, InputError
from eai.report.plot_files import styled, write
from eai.report.runs import read_runs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Records: TypeAlias = Annotated[
    list[Path], typer.Argument(help="Files of records, or folders with records.jsonl somewhere below.")
]

Plots: TypeAlias = Annotated[bool, typer.Option(help="Draw plots (needs the extra 'plots').")]

Figures: TypeAlias = "Iterator[tuple[str, Figure | None]]"
"""Figures by the names of their files, drawn one after the other; None where there is nothing to draw."""


def tables_of(records: Iterable[Path], data: Path | None) -> Tables:
    """The tidy tables of all runs in files and folders.

    Args:
        records: the files and folders.
        data: the folder of the data set; the user's if None.

    Raises:
        InputError: there are no records, or one is unusable.
    """
    with data_progress() as report:
        maker = TableMaker(Source(store(data), report, errata=ErrataChoice.NONE))
        for run in read_runs(records):
            maker.add(run.records)
    return maker.tables


@contextmanager
def with_extra() -> Iterator[None]:
    """Within it, the libraries of the extra ``analysis`` are needed.

    Raises:
        EaiError: one is not installed.
    """
    try:
        yield
    except ImportError as error:
        hint = "pip install 'embodied-agent-interface[analysis]'"
        raise EaiError(f"this analysis needs {error.name}: {hint}") from error


def draw_figures(figures: Figures, folder: Path) -> int:
    """Write figures in every format; returns how many. Without matplotlib there are none, and a remark.

    Raises:
        InputError: the folder cannot be written.
    """
    drawn = 0
    try:
        with styled():
            for name, figure in figures:
                if figure is not None:
                    write(figure, folder / name)
                    drawn += 1
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error
    except EaiError as error:
        errors().print(f"no plots: {error}", markup=False, highlight=False, soft_wrap=True)
    return drawn


def write_analysis(name: str, tables: Sequence[Table], figures: Figures, out: Path, *, plots: bool) -> None:
    """Write an analysis among others into a folder of its own, and say so.

    Raises:
        InputError: the folder cannot be written.
    """
    write_tables(out / name, name, tables)
    say(tables, draw_figures(figures, out / name) if plots else 0, out / name)


def say(tables: Sequence[Table], drawn: int, out: Path) -> None:
    """Say what was written."""
    message = f"{counted(len(tables), 'table')}, {counted(drawn, 'plot')}; in {out}"
    output().print(message, soft_wrap=True, highlight=False, markup=False)
