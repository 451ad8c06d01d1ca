"""Which rankings there are: the paper's tables, those of experiments, and what the paper reports besides.

What it reports besides is of a few models, or of other ways to ask. There its order says more than a rank
would: a way to ask stands below the one it is compared with.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from eai.abilities.protocol import Protocol
from eai.report.ranking import Notes, Ranking, Row, cell_of, ranked, with_best_marked
from eai.report.rows import cells_by_model, cells_of_run, floor_rows, paper_rows, published_rows, run_rows
from eai.report.run_summary import RunSummary
from eai.report.table_specs import (
    ColumnSpec,
    TableSpec,
    ability_title,
    columns_besides,
    of_ability,
    tables_of,
)
from eai.results.paper_tables import OTHER_TABLES, PaperTable, paper_setting, paper_table

_OTHER_SUBSET = ("human", "replanning_stochastic")
"""Tables on tasks that no run is on, or where actions fail that are possible."""

_LEFT_OUT = (
    "Runs under another protocol than `eai-1.0.5` count otherwise and are not set beside these figures."
)


def rankings(runs: Sequence[RunSummary], *, with_paper: bool) -> list[Ranking]:
    """All tables, by protocol and domain, in the order of the paper's.

    Args:
        runs: the runs, sorted by the order of their keys.
        with_paper: whether the paper's models appear beside ours.
    """
    places = groupby(runs, key=lambda item: (item.key.protocol, item.key.domain))
    return [
        table
        for (protocol, domain), group in ((place, list(items)) for place, items in places)
        for spec in tables_of(item.key.ability for item in group)
        if (table := make_ranking(spec, protocol, domain, group, with_paper=with_paper))
    ]


def make_ranking(
    spec: TableSpec,
    protocol: Protocol,
    domain: str,
    runs: Sequence[RunSummary],
    *,
    with_paper: bool,
) -> Ranking | None:
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
    rows = ranked(spec.primary, columns, rows)
    texts = tuple(notes.texts)
    return Ranking(spec.name, spec.title, protocol, domain, columns, column_notes, tuple(rows), texts)


def experiments(runs: Sequence[RunSummary]) -> list[Ranking]:
    """A table of each suite that has experiments, with those of its models that have any.

    The plain run of the same model stands above its experiments, as what they are to be compared with.

    Args:
        runs: the runs, plain ones too, sorted by the order of their keys.
    """
    places = groupby(runs, key=lambda item: item.key[:3])
    return [table for _, group in places if (table := _experiments_of(list(group))) is not None]


def _experiments_of(runs: Sequence[RunSummary]) -> Ranking | None:
    """The table of one suite, or None if it has no experiment."""
    models = {item.key.model for item in runs if item.key.experiment is not None}
    shown = [item for item in runs if item.key.model in models]
    if not shown:
        return None
    key = shown[0].key
    spec = of_ability(key.ability)
    notes = Notes()
    return Ranking(
        f"experiments_{spec.name}",
        f"Experiments: {ability_title(key.ability).lower()}",
        key.protocol,
        key.domain,
        spec.columns,
        ((),) * len(spec.columns),
        tuple(_experiment_rows(spec, shown, notes)),
        tuple(notes.texts),
    )


def _experiment_rows(spec: TableSpec, runs: Sequence[RunSummary], notes: Notes) -> Iterator[Row]:
    for item in runs:
        for row in run_rows(spec.columns, [item], {item.key.model: cells_of_run(item)}, notes):
            yield replace(row, model=item.key.name)


def besides(runs: Sequence[RunSummary]) -> list[Ranking]:
    """Those tables, one a domain, in the paper's order, below the runs that measure the same.

    Args:
        runs: the runs, sorted by the order of their keys.
    """
    papers = map(paper_table, OTHER_TABLES)
    return [
        _besides(paper, domain, runs)
        for paper in papers
        for domain in dict.fromkeys(column.domain for column in paper.columns)
    ]


def _besides(paper: PaperTable, domain: str, runs: Sequence[RunSummary]) -> Ranking:
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
    rows = [*_rows_of_runs(columns, alike, notes), *paper_rows(places, [paper], notes)]
    return Ranking(
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


def _rows_of_runs(columns: Sequence[ColumnSpec], runs: Sequence[RunSummary], notes: Notes) -> Iterator[Row]:
    """A row for each run; a table without a rank has them in the order of their names."""
    for item in runs:
        if item.key.protocol.value == paper_setting().protocol:
            cells = {item.key.model: cells_of_run(item)}
            yield from run_rows(columns, [item], cells, notes, with_paper=True)
