"""What the analyses of records share: from the records that a command is given to tables and plots."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple, TypeAlias
from urllib.parse import quote

import typer

from eai.abilities.verdict import Json
from eai.cli.console import counted, data_progress, errors, tell
from eai.cli.store import store
from eai.errors import EaiError, InputError, how_to_install
from eai.report.runs import RunKey, read_runs
from eai.results.plot_files import entitle, styled, write
from eai.results.plot_text import clipped
from eai.results.suites import SuiteKey
from eai.results.table import Table
from eai.results.table_files import write_tables
from eai.results.tidy import TableMaker, Tables
from eai.scoring.undisturbed import undisturbed
from eai.tasks.source import ErrataChoice, Source

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Records: TypeAlias = Annotated[
    list[Path], typer.Argument(help="Files of records, or folders with records.jsonl somewhere below.")
]

Plots: TypeAlias = Annotated[bool, typer.Option(help="Draw plots (needs the extra 'plots').")]

Explorer: TypeAlias = Annotated[
    Path | None,
    typer.Option(help="An explorer.html by eai report, to which examples link."),
]

Figures: TypeAlias = "Iterator[tuple[str, Figure | None]]"
"""Figures by the names of their files, drawn one after the other; None where there is nothing to draw."""


def of_suite(suite: SuiteKey, name: str, figure: Figure | None) -> tuple[str, Figure | None]:
    """A figure with the suite that it is of for a title, by the name of its files."""
    if figure is not None:
        entitle(figure, str(suite))
    return f"{name}-{suite.file_name}", figure


def of_run(key: RunKey, name: str, figure: Figure | None) -> tuple[str, Figure | None]:
    """A figure with the suite and the model that it is of for a title, by the name of its files."""
    if figure is not None:
        suite = SuiteKey(key.protocol.value, key.domain, key.ability.value)
        entitle(figure, f"{suite}, {clipped(key.model)}")
    return name, figure


def tables_of(records: Iterable[Path], data: Path | None, *, features: bool = True) -> Tables:
    """The tidy tables of all runs in files and folders.

    Args:
        records: the files and folders.
        data: the folder of the data set; the user's if None.
        features: whether the tables say what tasks are like, which the data set knows.

    Raises:
        InputError: there are no records, or one is unusable.
    """
    with data_progress() as report, undisturbed():
        maker = TableMaker(Source(store(data), report, errata=ErrataChoice.NONE), features=features)
        for run in read_runs(records):
            maker.add(run.records)
    return maker.tables


def address(explorer: Path | None, folder: Path) -> str | None:
    """The address of an explorer as seen from a folder.

    Raises:
        InputError: there is none.
    """
    if explorer is None:
        return None
    if not explorer.is_file():
        raise InputError(f"--explorer {explorer}: no such file; eai report writes explorer.html")
    return quote(Path(os.path.relpath(explorer, folder)).as_posix())


@contextmanager
def with_extra() -> Iterator[None]:
    """Within it, the libraries of the extra ``analysis`` are needed.

    Raises:
        EaiError: one is not installed.
    """
    try:
        yield
    except ImportError as error:
        raise EaiError(f"this analysis needs {error.name}: {how_to_install('analysis')}") from error


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


class Written(NamedTuple):
    """What an analysis wrote: tables by name, and so many plots, into a folder."""

    tables: tuple[str, ...]
    plots: int
    folder: Path

    def __str__(self) -> str:
        return f"{counted(len(self.tables), 'table')}, {counted(self.plots, 'plot')}; in {self.folder}"

    def to_json(self) -> Json:
        """The same for programs."""
        return {"folder": str(self.folder), "tables": list(self.tables), "plots": self.plots}


def write_analysis(
    name: str, tables: Sequence[Table], figures: Figures, folder: Path, *, plots: bool
) -> Written:
    """Write the tables of an analysis, and its figures where they are wanted.

    Raises:
        InputError: the folder cannot be written.
    """
    write_tables(folder, name, tables)
    drawn = draw_figures(figures, folder) if plots else 0
    return Written(tuple(table.name for table in tables), drawn, folder)


def say(*written: Written, as_json: bool) -> None:
    """Say what was written, a line or an object each."""
    tell(*map(str, written), value=[each.to_json() for each in written], as_json=as_json)
