"""Tables: rows of models, ours and the paper's, ranked, with the best in bold and footnotes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from eai.abilities.protocol import Ability, Protocol
from eai.report.paper_rows import floor_rows, paper_rows, published_rows
from eai.report.row import Cell, Cells, Notes, Row, RowSource, cell_of
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ColumnSpec, TableSpec, ability_title
from eai.results.average import AVERAGE, average_performance, average_weights
from eai.results.certainty import Cases, certainty_of_mean
from eai.results.coverage import together
from eai.results.paper_tables import paper_setting, paper_table
from eai.results.published_scores import is_null_model


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


def make_table(
    spec: TableSpec,
    protocol: Protocol,
    domain: str,
    runs: Sequence[RunSummary],
    *,
    with_paper: bool,
) -> Table | None:
    """The table of the runs of one protocol and domain, or None if they have none of its numbers.

    The paper's rows stand only among runs under its protocol. Under another one its models stand as their
    published answers were scored under that protocol. Below them all stand the null models, without a rank.
    """
    known = cells_by_model(runs)
    columns = tuple(
        column
        for column in spec.columns
        if any(cell_of(cells, column).percent is not None for cells in known.values())
    )
    if not columns:
        return None
    notes = Notes()
    rows = list(run_rows(columns, runs, known, notes, with_paper=with_paper))
    places = [column.place(domain) for column in columns]
    papers = []
    if with_paper and protocol.value == paper_setting().protocol:
        papers = [paper_table(name) for name in paper_setting().tables[spec.name]]
    elif with_paper:
        rows += published_rows(columns, protocol, domain, runs, notes)
    column_notes = tuple(notes.on_column(papers, place) for place in places)
    rows += paper_rows(places, papers, notes)
    rows += floor_rows(columns, protocol, domain, runs, notes)
    rows = _ranked(spec.primary, columns, rows)
    texts = tuple(notes.texts)
    return Table(spec.name, spec.title, protocol, domain, columns, column_notes, tuple(rows), texts)


def run_rows(
    columns: Sequence[ColumnSpec],
    runs: Sequence[RunSummary],
    known: Mapping[str, Cells],
    notes: Notes,
    *,
    with_paper: bool = False,
) -> Iterator[Row]:
    """A row for each model that has any of the columns' numbers, with footnotes on what it leaves open.

    Args:
        columns: the columns.
        runs: the runs of one protocol and domain.
        known: all numbers of each of their models.
        notes: where the footnotes go.
        with_paper: whether the paper's rows stand beside them, which another planner judged.
    """
    abilities = {column.ability for column in columns}
    planners = {name for run in runs for name in run.planners}
    for model, cells in known.items():
        found = tuple(cell_of(cells, column) for column in columns)
        if any(cell.percent is not None for cell in found):
            shown = [run for run in runs if run.key.model == model and run.key.ability in abilities]
            remarks = [
                f"{ability_title(run.key.ability)}: {run.coverage.remark}"
                for run in shown
                if run.coverage.remark
            ]
            if len(planners) > 1 or with_paper:
                judged = [", ".join(run.planners) for run in shown if run.planners]
                remarks += [f"Planner that judged operators: {names}." for names in judged]
            numbers = tuple(notes.number(remark) for remark in remarks)
            source = RowSource.FLOOR if is_null_model(model) else RowSource.RUN
            yield Row(model, source, found, together(run.coverage for run in shown), numbers)


def cells_by_model(runs: Sequence[RunSummary]) -> dict[str, Cells]:
    """All numbers of each model of one protocol and domain, the average over abilities included."""
    found: dict[str, dict[tuple[Ability | None, str], Cell]] = {}
    cases: dict[str, dict[tuple[Ability, str], Cases]] = {}
    for item in runs:
        ability, model = item.key.ability, item.key.model
        found.setdefault(model, {}).update(cells_of_run(item))
        cases.setdefault(model, {}).update({(ability, name): each for name, each in item.cases.items()})
    for model, cells in found.items():
        average = _average(cells, cases[model])
        covered = together(item.coverage for item in runs if item.key.model == model)
        cells[None, AVERAGE] = replace(average, coverage=covered)
    return dict(found)


def cells_of_run(item: RunSummary) -> Cells:
    """All numbers of one run."""
    return {
        (item.key.ability, metric): Cell(rate.percent, rate, item.certainties[metric], coverage=item.coverage)
        for metric, rate in item.rates.items()
    }


def _average(cells: Cells, cases: Mapping[tuple[Ability, str], Cases]) -> Cell:
    percents = {(a, metric): cell.percent for (a, metric), cell in cells.items() if a}
    percent = average_performance(percents)
    if percent is None:
        return Cell(None)
    parts = [(weight, cases[place]) for place, weight in average_weights(percents).items()]
    return Cell(percent, certainty=certainty_of_mean(parts))


def _ranked(primary: Sequence[str], columns: Sequence[ColumnSpec], rows: Sequence[Row]) -> list[Row]:
    """The rows by rank, with the best of each column marked."""
    names = [column.metric for column in columns]
    place = next((names.index(name) for name in primary if name in names), 0)
    values = [row.cells[place].percent if row.competes else None for row in rows]
    ranks = [None if v is None else 1 + sum(_above(other, v) for other in values) for v in values]
    ranked = [
        replace(row, rank=rank) for row, rank in zip(with_best_marked(columns, rows), ranks, strict=True)
    ]
    order = list(RowSource)
    return sorted(
        ranked, key=lambda row: (row.rank is None, row.rank or 0, order.index(row.source), row.model)
    )


def with_best_marked(columns: Sequence[ColumnSpec], rows: Sequence[Row]) -> list[Row]:
    """The rows with the best of each column marked if there is something to compare."""
    best = [
        _best(column, [row.cells[i].percent for row in rows if _may_be_best(row, row.cells[i])])
        for i, column in enumerate(columns)
    ]
    return [
        replace(row, cells=tuple([_marked(row, *pair) for pair in zip(row.cells, best, strict=True)]))
        for row in rows
    ]


def _marked(row: Row, cell: Cell, best: str | None) -> Cell:
    is_best = best is not None and _may_be_best(row, cell) and _shown(cell.percent) == best
    return replace(cell, best=is_best)


def _may_be_best(row: Row, cell: Cell) -> bool:
    return cell.ranked and row.source is not RowSource.FLOOR


def _above(other: float | None, value: float) -> bool:
    return other is not None and round(other, 1) > round(value, 1)


def _best(column: ColumnSpec, values: Sequence[float | None]) -> str | None:
    known = [value for value in values if value is not None]
    return _shown(max(known)) if column.more_is_better and len(known) > 1 else None


def _shown(percent: float | None) -> str | None:
    return None if percent is None else f"{percent:.1f}"
