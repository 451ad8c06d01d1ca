"""Rows of tables: one model's numbers, with where they are from and what they leave open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from eai.abilities.protocol import Ability
from eai.report.table_specs import ColumnSpec
from eai.results.certainty import Certainty, Interval
from eai.results.coverage import Coverage
from eai.results.paper_tables import PaperColumn, PaperTable
from eai.results.rate import Rate


@dataclass(frozen=True, slots=True)
class Cell:
    """One number.

    Attributes:
        percent: the number, None where there is none.
        rate: what it is a share of; None for averages and for the paper's figures.
        certainty: how sure it is; None for the paper's figures.
        best: whether no other row of the column is better.
        notes: numbers of footnotes, from 1.
        coverage: how much of its suites is answered; None for the paper's figures, which do not say.
    """

    percent: float | None
    rate: Rate | None = None
    certainty: Certainty | None = None
    best: bool = False
    notes: tuple[int, ...] = ()
    coverage: Coverage | None = None

    @property
    def interval(self) -> Interval | None:
        """Its 95 % interval; None for the paper's figures."""
        return None if self.certainty is None else self.certainty.interval

    @property
    def ranked(self) -> bool:
        """Whether it may be compared with those of other rows."""
        return self.coverage is None or self.coverage.ranked


class RowSource(str, Enum):
    """Where the numbers of a row are from."""

    RUN = "run"
    PAPER = "paper"
    """As the paper prints them."""
    PUBLISHED = "published"
    """The published answers of one of the paper's models, scored by us."""
    FLOOR = "floor"
    """What a null model earns, which decides nothing."""


@dataclass(frozen=True, slots=True)
class Row:
    """One model.

    Attributes:
        coverage: how much of its suites is answered; None of the paper's rows, which do not say.
        notes: numbers of footnotes on the whole of it, from 1.
        rank: by the table's primary column and shared by equals; None if there is no number there, or if the
            row is not ranked for what it does not answer.
    """

    model: str
    source: RowSource
    cells: tuple[Cell, ...]
    coverage: Coverage | None = None
    notes: tuple[int, ...] = ()
    rank: int | None = None

    @property
    def label(self) -> str:
        """The model, and where its numbers are from if not from a run."""
        return self.model if self.source is RowSource.RUN else f"{self.model} ({self.source.value})"

    @property
    def competes(self) -> bool:
        """Whether it may have a rank, and the best number of a column."""
        return self.source is not RowSource.FLOOR and (self.coverage is None or self.coverage.ranked)

    @property
    def answered(self) -> str:
        """How many tasks of how many are answered; empty of the paper's rows."""
        return "" if self.coverage is None else str(self.coverage)


Cells = Mapping[tuple["Ability | None", str], Cell]
"""What is known of one model in one domain: (ability, metric) -> number."""


def cell_of(cells: Cells, column: ColumnSpec) -> Cell:
    """The number of a column, or the cell without one."""
    return cells.get((column.ability, column.metric), Cell(None))


class Notes:
    """Footnotes in the order in which they are first needed."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def number(self, text: str) -> int:
        """The number of a footnote, which is written down if it is new."""
        if text not in self.texts:
            self.texts.append(text)
        return self.texts.index(text) + 1

    def on_column(self, papers: Sequence[PaperTable], column: PaperColumn) -> tuple[int, ...]:
        """The numbers of the notes on a whole column."""
        notes = [n for paper in papers for n in paper.notes if not n.models and column in n.columns]
        return tuple(sorted({self.number(note.text) for note in notes}))

    def on_cell(self, paper: PaperTable, model: str, column: PaperColumn) -> tuple[int, ...]:
        """The numbers of the notes on a cell in particular."""
        notes = [note for note in paper.notes if note.models and note.is_on(model, column)]
        return tuple(sorted({self.number(note.text) for note in notes}))
