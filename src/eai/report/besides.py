"""What the paper reports besides its tables of all models: of a few models, or of other ways to ask.

Here the paper's order says more than a rank would: a way to ask stands below the one it is compared with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from eai.abilities.protocol import Protocol
from eai.report.paper_rows import paper_rows
from eai.report.row import Notes, Row
from eai.report.run_summary import RunSummary
from eai.report.table import Table, cells_of_run, run_rows, with_best_marked
from eai.report.table_specs import ColumnSpec, columns_besides
from eai.results.paper_tables import OTHER_TABLES, PaperTable, paper_setting, paper_table

_OTHER_SUBSET = ("human", "replanning_stochastic")
"""Tables on tasks that no run is on, or where actions fail that are possible."""

_LEFT_OUT = (
    "Runs under another protocol than `eai-1.0.5` count otherwise and are not set beside these figures."
)


def tables_besides(runs: Sequence[RunSummary]) -> list[Table]:
    """Those tables, one a domain, in the paper's order, below the runs that measure the same.

    Args:
        runs: the runs, sorted by the order of their keys.
    """
    papers = map(paper_table, OTHER_TABLES)
    return [
        _table(paper, domain, runs)
        for paper in papers
        for domain in dict.fromkeys(column.domain for column in paper.columns)
    ]


def _table(paper: PaperTable, domain: str, runs: Sequence[RunSummary]) -> Table:
    columns = tuple(column for column in columns_besides()[paper.name] if _has_figures(paper, column, domain))
    abilities = {column.ability for column in columns}
    alike = [item for item in runs if item.key.domain == domain and item.key.ability in abilities]
    if paper.name in _OTHER_SUBSET:
        alike = []
    notes = Notes()
    places = [column.place(domain) for column in columns]
    left_out = any(item.key.protocol.value != paper_setting().protocol for item in alike)
    remarks = (notes.number(_LEFT_OUT),) if left_out else ()
    column_notes = tuple((*remarks, *notes.on_column([paper], place)) for place in places)
    rows = [*_run_rows(columns, alike, notes), *paper_rows(places, [paper], notes)]
    return Table(
        f"paper_{paper.name}",
        paper.title,
        Protocol(paper_setting().protocol),
        domain,
        columns,
        column_notes,
        tuple(with_best_marked(columns, rows)),
        tuple(notes.texts),
    )


def _has_figures(paper: PaperTable, column: ColumnSpec, domain: str) -> bool:
    return any(paper.figure(model, column.place(domain)) is not None for model in paper.rows)


def _run_rows(columns: Sequence[ColumnSpec], runs: Sequence[RunSummary], notes: Notes) -> Iterator[Row]:
    """A row for each run; a table without a rank has them in the order of their names."""
    for item in runs:
        if item.key.protocol.value == paper_setting().protocol:
            cells = {item.key.model: cells_of_run(item)}
            yield from run_rows(columns, [item], cells, notes, with_paper=True)
