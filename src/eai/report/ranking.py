"""Rankings: rows of models, ours and the paper's, ranked, with the best in bold and footnotes.

A ranking is of one domain under one protocol. What readers see of it is a `Table`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

from eai.abilities.declaration import MetricColumn
from eai.abilities.protocol import Ability, Protocol
from eai.benchmark.registry import title_of
from eai.results.certainty import Certainty, Interval
from eai.results.coverage import Coverage
from eai.results.rate import Rate
from eai.results.table import NO_NUMBER, Column, Estimate, Label, Table
from eai.results.table import Cell as TableCell


@dataclass(frozen=True, slots=True)
class Cell:
    """One number.

    Attributes:
        percent: the number, None where there is none.
        rate: what it is a share of; None for averages and for the paper's figures.
        certainty: how sure it is; None for the paper's figures.
        best: whether no other row of the column is better.
        notes: footnotes.
        coverage: how much of its suites is answered; None for the paper's figures, which do not say.
    """

    percent: float | None
    rate: Rate | None = None
    certainty: Certainty | None = None
    best: bool = False
    notes: tuple[str, ...] = ()
    coverage: Coverage | None = None

    @property
    def interval(self) -> Interval | None:
        """Its 95 % interval; None for the paper's figures."""
        return None if self.certainty is None else self.certainty.interval

    def shown(self, ranking: Ranking) -> Estimate:
        """The number as readers of a ranking see it."""
        low, high = (None, None) if self.interval is None else self.interval
        return Estimate(self.percent, low, high, best=self.best, notes=ranking.numbers(self.notes))

    @property
    def ranked(self) -> bool:
        """Whether it may be compared with those of other rows."""
        return self.coverage is None or self.coverage.ranked


RowSource: TypeAlias = Literal["run", "paper", "published", "floor"]
"""Where the numbers of a row are from, in the order of rows of one rank.

- run: a run.
- paper: the paper, as it prints them.
- published: the published answers of one of the paper's models, scored by us.
- floor: a null model, which decides nothing.
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One model.

    Attributes:
        cells: its number in each column of the table.
        coverage: how much of its suites is answered; None of the paper's rows, which do not say.
        harness: what the model acts in.
        effort: how much it is to reason.
        notes: footnotes on the whole of it.
        rank: by the table's primary column and shared by equals; None if there is no number there, or if the
            row is not ranked for what it does not answer.
    """

    model: str
    source: RowSource
    cells: Mapping[MetricColumn, Cell]
    coverage: Coverage | None = None
    notes: tuple[str, ...] = ()
    rank: int | None = None
    harness: str = ""
    effort: str = ""

    @property
    def competes(self) -> bool:
        """Whether it may have a rank, and the best number of a column."""
        return self.source != "floor" and (self.coverage is None or self.coverage.ranked)

    @property
    def all_notes(self) -> list[str]:
        """The footnotes on the whole of it, and those on its numbers."""
        return [*self.notes, *(note for cell in self.cells.values() for note in cell.notes)]

    def shown(self, ranking: Ranking) -> tuple[TableCell, ...]:
        """The cells that readers see, one for each of `_BESIDE`, and its numbers."""
        origin = "" if self.source == "run" else self.source
        answered = NO_NUMBER if self.coverage is None else str(self.coverage)
        numbers = [cell.shown(ranking) for cell in self.cells.values()]
        model = Label(self.model, origin=origin, notes=ranking.numbers(self.notes))
        return (self.rank, model, self.harness, self.effort, answered, *numbers)


Cells = Mapping[tuple["Ability | None", str], Cell]
"""The numbers of one model in one domain: (ability, metric) -> number."""


def cell_of(cells: Cells, column: MetricColumn) -> Cell:
    """The number of a column, or the cell without one."""
    return cells.get((column.ability, column.metric), Cell(None))


@dataclass(frozen=True, slots=True)
class Ranking:
    """One table of one domain under one protocol.

    Attributes:
        columns: only those in which some row has a number, each with the footnotes on the whole of it.
        rows: by rank.
        notes: all footnotes, the first is number 1.
        by: the column that ranks, which need not be one that is shown; None of a table without ranks.
    """

    name: str
    title: str
    protocol: Protocol
    domain: str
    columns: Mapping[MetricColumn, tuple[str, ...]]
    rows: tuple[Row, ...]
    notes: tuple[str, ...]
    by: MetricColumn | None = None

    def numbers(self, notes: Iterable[str]) -> tuple[int, ...]:
        """The numbers of footnotes."""
        return tuple(sorted({self.notes.index(note) + 1 for note in notes}))

    @property
    def ranked_by(self) -> str:
        """How the order of rows is told: the heading of the column that ranks, or nothing."""
        if self.by is None:
            return ""
        return f", ranked by {_alone(self.by, [column.group for column in (*self.columns, self.by)])}"

    def table(self) -> Table:
        """The table that readers see; a number has its interval, where it is ours.

        The definition is a caption, whose last sentence may go on.
        """
        groups = [column.group for column in self.columns]
        columns = [
            Column(each.metric, each.label, each.group, _alone(each, groups), 1, True, self.numbers(notes))
            for each, notes in self.columns.items()
        ]
        table = Table(
            self.name,
            self.title,
            self._caption(),
            (*_BESIDE, *columns),
            tuple([row.shown(self) for row in self.rows]),
            notes=self.notes,
        )
        unused = {name for name in _OF_AGENT if not any(getattr(row, name) for row in self.rows)}
        return table.without(unused)

    def _caption(self) -> str:
        """The protocol is that of runs, so a table of the paper's rows alone has none."""
        title = f"{self.title}, {title_of(self.domain)}"
        if all(row.source == "paper" for row in self.rows):
            return f"{title}. Percent{self.ranked_by}"
        return f"{title}, protocol {self.protocol.value}. Percent{self.ranked_by}"


_BESIDE = (
    Column("rank", "#", number=True),
    Column("model", "Model", alone="model", number=False),
    Column("harness", "Harness", alone="harness", number=False),
    Column("effort", "Effort", alone="effort", number=False),
    Column("answered", "Answered", alone="answered", number=True),
)
"""The columns before the numbers of a row."""

_OF_AGENT = ("harness", "effort")
"""Those of them that stand only where a row has something there."""


def _alone(column: MetricColumn, groups: Sequence[str]) -> str:
    """A column's heading, with its group's name only where labels alone would not do."""
    ambiguous = len(set(groups)) > 1 and column.label in ("P", "R", "F1", "Task", "Execution", "Planner")
    alike = column.label in ("State", "Relation", "Action", "Total")
    return f"{column.group}: {column.label}" if ambiguous or alike else column.label


def ranking_column(primary: Sequence[str], columns: Sequence[MetricColumn]) -> MetricColumn:
    """The column that ranks: the first that is there of some metrics, else the first one."""
    return next((column for name in primary for column in columns if column.metric == name), columns[0])


def ranked(by: MetricColumn, rows: Sequence[Row]) -> list[Row]:
    """The rows by rank, by one of their columns, with the best of each column marked."""
    ranks = ranks_of([_printed(row.cells[by]) if row.competes else None for row in rows])
    marked, order = zip(with_best_marked(rows), ranks, strict=True), get_args(RowSource)
    return sorted(
        (replace(row, rank=rank) for row, rank in marked),
        key=lambda row: (row.rank is None, row.rank or 0, order.index(row.source), row.model),
    )


def ranks_of(values: Sequence[float | None]) -> list[int | None]:
    """The rank of each value, 1 of the greatest and shared by equals; None where there is none."""
    known = [value for value in values if value is not None]
    return [None if value is None else 1 + sum(other > value for other in known) for value in values]


def with_best_marked(rows: Sequence[Row]) -> list[Row]:
    """The rows with the best of each column marked if there is something to compare."""
    best: dict[MetricColumn, float] = {}
    for column in dict.fromkeys(column for row in rows for column in row.cells if column.more_is_better):
        known = [number for row in rows if (number := _compared(row, row.cells[column])) is not None]
        best |= {column: max(known)} if len(known) > 1 else {}
    return [
        replace(
            row, cells={column: _marked(row, cell, best.get(column)) for column, cell in row.cells.items()}
        )
        for row in rows
    ]


def _marked(row: Row, cell: Cell, best: float | None) -> Cell:
    return replace(cell, best=best is not None and _compared(row, cell) == best)


def _compared(row: Row, cell: Cell) -> float | None:
    return _printed(cell) if cell.ranked and row.source != "floor" else None


def _printed(cell: Cell) -> float | None:
    return None if cell.percent is None else round(cell.percent, 1)
