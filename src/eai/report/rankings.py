"""Which rankings there are: the paper's tables, those of experiments, and what the paper reports besides.

What it reports besides is of a few models, or of other ways to ask. There its order says more than a rank
would: a way to ask stands below the one it is compared with.

Rows are of runs, of the paper's models, as it prints them or scored by us, and of null models. The paper's
figures are of one protocol, and stand only beside runs under it. Beside runs under another one stand the
published answers, scored under that protocol.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import Literal

from eai.abilities.declaration import MetricColumn
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol
from eai.data.grouping import grouped
from eai.report.ranking import (
    Cell,
    Cells,
    Ranking,
    Row,
    RowSource,
    cell_of,
    ranked,
    ranking_column,
    with_best_marked,
)
from eai.report.run_summary import RunSummary
from eai.report.table_specs import (
    TableSpec,
    ability_title,
    columns_of,
    of_ability,
    place_of_column,
    tables_of,
)
from eai.results import paper_tables
from eai.results.certainty import Cases, certainty_of_mean
from eai.results.coverage import together
from eai.results.paper_tables import PaperColumn, PaperTable, PublishedSuite
from eai.results.summary import AVERAGE, Place, average_performance, average_weights

_FLOOR = (
    "Floor: what is earned without deciding anything, by null models; never ranked. "
    f"{'; '.join(f'{model} {what}' for model, what in paper_tables.NULL_MODELS.items())}."
)
_OTHER_DATA = "Scored against other data than the runs: {suites}."


def run_rows(
    columns: Sequence[MetricColumn],
    runs: Sequence[RunSummary],
    known: Mapping[str, Cells],
    *,
    with_paper: bool = False,
) -> Iterator[Row]:
    """A row for each model that has any of the columns' numbers, with footnotes on what it leaves open.

    Args:
        columns: the columns.
        runs: the runs of one protocol and domain.
        known: all numbers of each of their models, by the names of runs.
        with_paper: whether the paper's rows stand beside them, which another planner judged.
    """
    abilities = {column.ability for column in columns}
    planners = {name for run in runs for name in run.planners}
    for name, cells in known.items():
        found = {column: cell_of(cells, column) for column in columns}
        if any(cell.percent is not None for cell in found.values()):
            shown = [run for run in runs if run.key.name == name and run.key.ability in abilities]
            remarks = [
                f"{ability_title(run.key.ability)}: {run.coverage.remark}"
                for run in shown
                if run.coverage.remark
            ]
            if len(planners) > 1 or with_paper:
                judged = [", ".join(run.planners) for run in shown if run.planners]
                remarks += [f"Planner that judged operators: {names}." for names in judged]
            model, experiment = shown[0].key.model, shown[0].key.experiment or Experiment()
            source: RowSource = "floor" if paper_tables.is_null_model(model) else "run"
            yield Row(
                model,
                source,
                found,
                together(run.coverage for run in shown),
                tuple(remarks),
                harness=experiment.harness or "",
                effort=experiment.effort or "",
            )


def cells_by_model(runs: Sequence[RunSummary]) -> dict[str, Cells]:
    """All numbers of the runs of one protocol and domain by their names, with the average over abilities."""
    found: dict[str, Cells] = {}
    for name, items in grouped((item.key.name, item) for item in runs).items():
        cells: dict[tuple[Ability | None, str], Cell] = {
            (item.key.ability, metric): Cell(
                rate.percent, rate, item.certainties[metric], coverage=item.coverage
            )
            for item in items
            for metric, rate in item.rates.items()
        }
        cases = {(item.key.ability, metric): of for item in items for metric, of in item.cases.items()}
        average = _average(cells, cases)
        cells[None, AVERAGE] = replace(average, coverage=together(item.coverage for item in items))
        found[name] = cells
    return found


def _average(cells: Cells, cases: Mapping[Place, Cases]) -> Cell:
    percents = _percents(cells)
    percent = average_performance(percents)
    if percent is None:
        return Cell(None)
    parts = [(weight, cases[place]) for place, weight in average_weights(percents).items()]
    return Cell(percent, certainty=certainty_of_mean(parts))


def _percents(cells: Cells) -> dict[Place, float | None]:
    return {(ability, metric): cell.percent for (ability, metric), cell in cells.items() if ability}


def paper_rows(places: Mapping[MetricColumn, PaperColumn], papers: Sequence[PaperTable]) -> Iterator[Row]:
    """The paper's models; of two tables with a figure for a place of a column the first is taken."""
    for model in dict.fromkeys(model for paper in papers for model in paper.rows):
        cells = {column: _paper_cell(model, place, papers) for column, place in places.items()}
        if any(cell.percent is not None for cell in cells.values()):
            yield Row(model, "paper", cells)


def _paper_cell(model: str, column: PaperColumn, papers: Sequence[PaperTable]) -> Cell:
    for paper in papers:
        figure = paper.figure(model, column)
        if figure is not None:
            return Cell(figure, notes=tuple(paper.notes.get((model, column), ())))
    return Cell(None)


def _notes_on(column: PaperColumn, papers: Sequence[PaperTable]) -> tuple[str, ...]:
    """The notes on a whole column."""
    return tuple([note for paper in papers for note in paper.notes.get(("", column), ())])


def scored_rows(
    source: Literal["published", "floor"], columns: Sequence[MetricColumn], runs: Sequence[RunSummary]
) -> Iterator[Row]:
    """Models as a table that comes with the package has them; what it says of itself are their footnotes.

    Args:
        source: the paper's models, whose published answers were scored, or null models.
        columns: the columns.
        runs: the runs beside which they stand, of one protocol and domain. There are no rows under a protocol
            that they were not scored under.
    """
    (protocol, domain, *_), floor = runs[0].key, source == "floor"
    table = paper_tables.null_scores(protocol.value) if floor else paper_tables.published_scores()
    if table.protocol != protocol.value:
        return
    abilities = dict.fromkeys(column.ability for column in columns if column.ability)
    suites = {a: table.suites[f"{domain}/{a}"] for a in abilities if f"{domain}/{a}" in table.suites}
    models = dict.fromkeys(model for suite in suites.values() for model in suite.models)
    texts = [_FLOOR if floor else _about_published(len(models))]
    texts += [note for suite in suites.values() for note in suite.notes]
    pairs = [(run, suites[run.key.ability]) for run in runs if run.key.ability in suites]
    other = [run.key.ability for run, suite in pairs if run.data_sha256 != (suite.data_sha256,)]
    if other:
        texts.append(_OTHER_DATA.format(suites=", ".join(map(ability_title, dict.fromkeys(other)))))
    for model in models:
        cells = _published_cells(model, suites)
        found = {column: cell_of(cells, column) for column in columns}
        if any(cell.percent is not None for cell in found.values()):
            covered = together(suite.coverage(model) for suite in suites.values() if model in suite.models)
            yield Row(model, source, found, covered, tuple(texts))


def _about_published(known: int) -> str:
    """The footnote on so many models whose published answers were scored."""
    sha256, everyone = paper_tables.published_scores_sha256(), set(paper_tables.paper_models().values())
    return (
        f"Answers that the paper's authors published, scored by us under this protocol (table {sha256:.12}): "
        f"those of {known} of the paper's {len(everyone)} models; the others are to be added."
    )


def _published_cells(model: str, suites: Mapping[Ability, PublishedSuite]) -> Cells:
    cells: dict[tuple[Ability | None, str], Cell] = {
        (ability, metric): Cell(rate.percent, rate, coverage=suite.coverage(model))
        for ability, suite in suites.items()
        if model in suite.models
        for metric, rate in suite.rates(model).items()
    }
    cells[None, AVERAGE] = Cell(average_performance(_percents(cells)))
    return cells


_LEFT_OUT = (
    "Runs under another protocol than `eai-1.0.5` count otherwise and are not set beside these figures."
)


def rankings(runs: Sequence[RunSummary], *, with_paper: bool) -> list[Ranking]:
    """All tables, by protocol and domain, in the order of the paper's.

    Args:
        runs: the runs, sorted by the order of their keys.
        with_paper: whether the paper's models appear beside ours.
    """
    return [
        table
        for group in grouped((item.key[:2], item) for item in runs).values()
        for known in [cells_by_model(group)]
        for spec in tables_of(item.key.ability for item in group)
        if (table := make_ranking(spec, group, known, with_paper=with_paper))
    ]


def make_ranking(
    spec: TableSpec, runs: Sequence[RunSummary], known: Mapping[str, Cells], *, with_paper: bool
) -> Ranking | None:
    """The table of the runs of one protocol and domain, or None if they have none of its numbers.

    All numbers of the runs are known (`cells_by_model`).

    The paper's rows stand only among runs under its protocol. Under another one its models stand as their
    published answers were scored under that protocol. Below them all stand the null models, without a rank.
    """
    columns = tuple(
        column
        for column in spec.columns
        if any(cell_of(cells, column).percent is not None for cells in known.values())
    )
    if not columns:
        return None
    protocol, domain = runs[0].key[:2]
    by = ranking_column(spec.primary, columns)
    ours = [_with_missing(row, by) for row in run_rows(columns, runs, known, with_paper=with_paper)]
    places = {column: place_of_column(column, domain) for column in columns}
    papers, others = [], list[Row]()
    if with_paper and protocol.value == paper_tables.paper_setting().protocol:
        papers = [paper_tables.paper_table(name) for name in paper_tables.paper_setting().tables[spec.name]]
    elif with_paper:
        others += scored_rows("published", columns, runs)
    others += [*paper_rows(places, papers), *scored_rows("floor", columns, runs)]
    on_columns = {column: _notes_on(place, papers) for column, place in places.items()}
    notes = _in_order(_of_rows(ours), *on_columns.values(), _of_rows(others))
    rows = tuple(ranked(by, [*ours, *others]))
    return Ranking(spec.name, spec.title, protocol, domain, on_columns, rows, notes, by)


def _in_order(*notes: Iterable[str]) -> tuple[str, ...]:
    """Footnotes in the order in which they are first needed."""
    return tuple(dict.fromkeys(chain(*notes)))


def _of_rows(rows: Iterable[Row]) -> list[str]:
    return [note for row in rows for note in row.all_notes]


def _with_missing(row: Row, by: MetricColumn) -> Row:
    """A row, with a footnote on what it lacks if it has no number in the column that ranks."""
    if row.cells[by].percent is not None:
        return row
    lacking = [column for column, cell in row.cells.items() if cell.percent is None]
    missing = dict.fromkeys([ability_title(each.ability).lower() for each in lacking if each.ability])
    unasked = f": {', '.join(missing)} not asked" if missing else ""
    note = f"No rank, as there is no {by.label.lower()}{unasked}."
    return replace(row, notes=(*row.notes, note))


def experiments(runs: Sequence[RunSummary]) -> list[Ranking]:
    """A table of each suite that has experiments, with those of its models that have any.

    The plain run of the same model stands above its experiments, as what they are to be compared with.

    Args:
        runs: the runs, plain ones too, sorted by the order of their keys.
    """
    suites = grouped((item.key[:3], item) for item in runs).values()
    return [table for group in suites if (table := _experiments_of(group)) is not None]


def _experiments_of(runs: Sequence[RunSummary]) -> Ranking | None:
    """The table of one suite, or None if it has no experiment."""
    models = {item.key.model for item in runs if not item.key.is_plain}
    shown = [item for item in runs if item.key.model in models]
    if not shown:
        return None
    key = shown[0].key
    spec = of_ability(key.ability)
    rows = tuple(
        [
            replace(row, model=item.key.name, harness="", effort="")
            for item in shown
            for row in run_rows(spec.columns, [item], cells_by_model([item]))
        ]
    )
    name, title = f"experiments_{spec.name}", f"Experiments: {ability_title(key.ability).lower()}"
    columns, notes = dict.fromkeys(spec.columns, ()), _in_order(_of_rows(rows))
    return Ranking(name, title, key.protocol, key.domain, columns, rows, notes)


def besides(runs: Sequence[RunSummary]) -> list[Ranking]:
    """Those tables, one a domain, in the paper's order, below the runs that measure the same.

    Args:
        runs: the runs, sorted by the order of their keys.
    """
    papers = map(paper_tables.paper_table, paper_tables.paper_setting().others)
    return [
        _besides(paper, domain, runs)
        for paper in papers
        for domain in dict.fromkeys(column.domain for column in paper.columns)
    ]


def _besides(paper: PaperTable, domain: str, runs: Sequence[RunSummary]) -> Ranking:
    setting = paper_tables.paper_setting()
    known = columns_of(setting.others[paper.name])
    columns = tuple(column for column in known if _has_figures(paper, column, domain))
    abilities = {column.ability for column in columns}
    alike = [item for item in runs if item.key.domain == domain and item.key.ability in abilities]
    if paper.name in setting.other_tasks:
        alike = []
    places = {column: place_of_column(column, domain) for column in columns}
    ours = [item for item in alike if item.key.protocol.value == setting.protocol]
    remarks = (_LEFT_OUT,) if len(ours) < len(alike) else ()
    on_columns = {column: (*remarks, *_notes_on(place, [paper])) for column, place in places.items()}
    rows = [*run_rows(columns, ours, cells_by_model(ours), with_paper=True), *paper_rows(places, [paper])]
    marked, notes = tuple(with_best_marked(rows)), _in_order(*on_columns.values(), _of_rows(rows))
    name, protocol = f"paper_{paper.name}", Protocol(setting.protocol)
    return Ranking(name, paper.title, protocol, domain, on_columns, marked, notes)


def _has_figures(paper: PaperTable, column: MetricColumn, domain: str) -> bool:
    return any(paper.figure(model, place_of_column(column, domain)) is not None for model in paper.rows)
