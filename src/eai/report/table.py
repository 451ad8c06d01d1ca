"""Tables: rows of models, ours and the paper's, ranked, with the best in bold and footnotes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from eai.abilities.protocol import Ability, Protocol
from eai.metrics.average import AVERAGE, average_performance, average_weights
from eai.metrics.certainty import Cases, Certainty, Interval, certainty_of_mean
from eai.metrics.paper_tables import PaperColumn, PaperTable, paper_setting, paper_table
from eai.metrics.rate import Rate
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ColumnSpec, TableSpec


@dataclass(frozen=True, slots=True)
class Cell:
    """One number.

    Attributes:
        percent: the number, None where there is none.
        rate: what it is a share of; None for averages and for the paper's figures.
        certainty: how sure it is; None for the paper's figures.
        best: whether no other row of the column is better.
        notes: numbers of footnotes, from 1.
    """

    percent: float | None
    rate: Rate | None = None
    certainty: Certainty | None = None
    best: bool = False
    notes: tuple[int, ...] = ()

    @property
    def interval(self) -> Interval | None:
        """Its 95 % interval; None for the paper's figures."""
        return None if self.certainty is None else self.certainty.interval


@dataclass(frozen=True, slots=True)
class Row:
    """One model; the rank is by the table's primary column and shared by equals."""

    model: str
    from_paper: bool
    cells: tuple[Cell, ...]
    rank: int | None = None


@dataclass(frozen=True, slots=True)
class Table:
    """One table of one domain under one protocol.

    Attributes:
        columns: only those in which some row has a number.
        column_notes: for each column the numbers of the footnotes on the whole of it.
        rows: by rank.
        notes: the footnotes, the first is number 1.
    """

    name: str
    title: str
    protocol: Protocol
    domain: str
    columns: tuple[ColumnSpec, ...]
    column_notes: tuple[tuple[int, ...], ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...]


Cells = Mapping[tuple["Ability | None", str], Cell]
"""What is known of one model in one domain: (ability, metric) -> number."""


def make_table(
    spec: TableSpec,
    protocol: Protocol,
    domain: str,
    runs: Sequence[RunSummary],
    *,
    with_paper: bool,
) -> Table | None:
    """The table of the runs of one protocol and domain, or None if they have none of its numbers."""
    known = cells_by_model(runs)
    columns = tuple(
        column
        for column in spec.columns
        if any(cell_of(cells, column).percent is not None for cells in known.values())
    )
    if not columns:
        return None
    ours = [Row(model, False, tuple(cell_of(cells, c) for c in columns)) for model, cells in known.items()]
    ours = [row for row in ours if any(cell.percent is not None for cell in row.cells)]
    papers = [paper_table(name) for name in paper_setting().tables[spec.name]] if with_paper else []
    notes = Notes()
    places = [column.place(domain) for column in columns]
    column_notes = tuple(notes.on_column(papers, place) for place in places)
    rows = _ranked(spec.primary, columns, [*ours, *paper_rows(places, papers, notes)])
    texts = tuple(notes.texts)
    return Table(spec.name, spec.title, protocol, domain, columns, column_notes, tuple(rows), texts)


def cells_by_model(runs: Sequence[RunSummary]) -> dict[str, Cells]:
    """All numbers of each model of one protocol and domain, the average over abilities included."""
    found: dict[str, dict[tuple[Ability | None, str], Cell]] = {}
    cases: dict[str, dict[tuple[Ability, str], Cases]] = {}
    for item in runs:
        ability, model = item.key.ability, item.key.model
        found.setdefault(model, {}).update(cells_of_run(item))
        cases.setdefault(model, {}).update({(ability, name): each for name, each in item.cases.items()})
    for model, cells in found.items():
        cells[None, AVERAGE] = _average(cells, cases[model])
    return dict(found)


def cells_of_run(item: RunSummary) -> Cells:
    """All numbers of one run."""
    return {
        (item.key.ability, metric): Cell(rate.percent, rate, item.certainties[metric])
        for metric, rate in item.rates.items()
    }


def _average(cells: Cells, cases: Mapping[tuple[Ability, str], Cases]) -> Cell:
    percent = average_performance({(a, metric): cell.percent for (a, metric), cell in cells.items() if a})
    if percent is None:
        return Cell(None)
    parts = [(weight, cases[place]) for place, weight in average_weights().items()]
    return Cell(percent, certainty=certainty_of_mean(parts))


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


def paper_rows(columns: Sequence[PaperColumn], papers: Sequence[PaperTable], notes: Notes) -> Iterator[Row]:
    """The paper's models; of two tables with a figure the first is taken."""
    for model in dict.fromkeys(model for paper in papers for model in paper.rows):
        cells = tuple(_paper_cell(model, column, papers, notes) for column in columns)
        if any(cell.percent is not None for cell in cells):
            yield Row(model, True, cells)


def _paper_cell(model: str, column: PaperColumn, papers: Sequence[PaperTable], notes: Notes) -> Cell:
    for paper in papers:
        figure = paper.figure(model, column)
        if figure is not None:
            return Cell(figure, notes=notes.on_cell(paper, model, column))
    return Cell(None)


def _ranked(primary: str, columns: Sequence[ColumnSpec], rows: Sequence[Row]) -> list[Row]:
    """The rows by rank, with the best of each column marked."""
    names = [column.metric for column in columns]
    values = [row.cells[names.index(primary) if primary in names else 0].percent for row in rows]
    ranks = [None if v is None else 1 + sum(_above(other, v) for other in values) for v in values]
    ranked = [
        replace(row, rank=rank) for row, rank in zip(with_best_marked(columns, rows), ranks, strict=True)
    ]
    return sorted(ranked, key=lambda row: (row.rank is None, row.rank or 0, row.from_paper, row.model))


def with_best_marked(columns: Sequence[ColumnSpec], rows: Sequence[Row]) -> list[Row]:
    """The rows with the best of each column marked if there is something to compare."""
    best = [_best(column, [row.cells[i].percent for row in rows]) for i, column in enumerate(columns)]
    return [replace(row, cells=tuple(map(_marked, row.cells, best))) for row in rows]


def _marked(cell: Cell, best: str | None) -> Cell:
    return replace(cell, best=best is not None and _shown(cell.percent) == best)


def _above(other: float | None, value: float) -> bool:
    return other is not None and round(other, 1) > round(value, 1)


def _best(column: ColumnSpec, values: Sequence[float | None]) -> str | None:
    known = [value for value in values if value is not None]
    return _shown(max(known)) if column.more_is_better and len(known) > 1 else None


def _shown(percent: float | None) -> str | None:
    return None if percent is None else f"{percent:.1f}"
