"""The rows of rankings: of runs, of the paper's models (as it prints them or scored by us), of null models.

The paper's figures are of one protocol, and stand only beside runs under it. Beside runs under another one
stand the published answers, scored under that protocol.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from eai.abilities.protocol import Ability, Protocol
from eai.report.ranking import Cell, Cells, Notes, Row, RowSource, cell_of
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ColumnSpec, ability_title
from eai.results.average import AVERAGE, average_performance, average_weights
from eai.results.certainty import Cases, certainty_of_mean
from eai.results.coverage import together
from eai.results.paper_tables import PaperColumn, PaperTable, paper_models
from eai.results.published_scores import (
    NULL_MODELS,
    PublishedScores,
    PublishedSuite,
    is_null_model,
    null_scores,
    published_scores,
    published_scores_sha256,
)

_PUBLISHED = (
    "Answers that the paper's authors published, scored by us under this protocol (table {sha256:.12}): "
    "those of {known} of the paper's {all} models; the others are to be added."
)
_FLOOR = "Floor: what is earned without deciding anything, by null models; never ranked. {names}."
_OTHER_DATA = "Scored against other data than the runs: {suites}."


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


def paper_rows(columns: Sequence[PaperColumn], papers: Sequence[PaperTable], notes: Notes) -> Iterator[Row]:
    """The paper's models; of two tables with a figure the first is taken."""
    for model in dict.fromkeys(model for paper in papers for model in paper.rows):
        cells = tuple(_paper_cell(model, column, papers, notes) for column in columns)
        if any(cell.percent is not None for cell in cells):
            yield Row(model, RowSource.PAPER, cells)


def _paper_cell(model: str, column: PaperColumn, papers: Sequence[PaperTable], notes: Notes) -> Cell:
    for paper in papers:
        figure = paper.figure(model, column)
        if figure is not None:
            return Cell(figure, notes=notes.on_cell(paper, model, column))
    return Cell(None)


def published_rows(
    columns: Sequence[ColumnSpec],
    protocol: Protocol,
    domain: str,
    runs: Sequence[RunSummary],
    notes: Notes,
) -> Iterator[Row]:
    """The paper's models, as their published answers were scored under a protocol.

    Args:
        columns: the columns.
        protocol: the protocol of the table; there are no rows under one that they were not scored under.
        domain: the domain of the table.
        runs: the runs beside which they stand.
        notes: where footnotes go.
    """
    table = published_scores()
    if table.protocol != protocol.value:
        return
    suites = _suites(table, columns, domain)
    known = len({model for suite in suites.values() for model in suite.models})
    everyone = len(set(paper_models().values()))
    text = _PUBLISHED.format(sha256=published_scores_sha256(), known=known, all=everyone)
    yield from _scored_rows(suites, columns, runs, notes, RowSource.PUBLISHED, text)


def floor_rows(
    columns: Sequence[ColumnSpec],
    protocol: Protocol,
    domain: str,
    runs: Sequence[RunSummary],
    notes: Notes,
) -> Iterator[Row]:
    """The null models in the suites that come with the package; arguments as for `published_rows`."""
    suites = _suites(null_scores(protocol.value), columns, domain)
    names = "; ".join(f"{model} {what}" for model, what in NULL_MODELS.items())
    return _scored_rows(suites, columns, runs, notes, RowSource.FLOOR, _FLOOR.format(names=names))


def _suites(
    table: PublishedScores, columns: Sequence[ColumnSpec], domain: str
) -> Mapping[Ability, PublishedSuite]:
    """What a table of scores has of the abilities of columns."""
    abilities = dict.fromkeys(column.ability for column in columns if column.ability)
    return {a: suite for a in abilities if (suite := table.suite(domain, a.value)) is not None}


def _scored_rows(
    suites: Mapping[Ability, PublishedSuite],
    columns: Sequence[ColumnSpec],
    runs: Sequence[RunSummary],
    notes: Notes,
    source: RowSource,
    text: str,
) -> Iterator[Row]:
    """The models of a table of scores, with what it says of itself and its suites as footnotes."""
    texts = [text, *(note for suite in suites.values() for note in suite.notes)]
    other = [run.key.ability for run in runs if _is_on_other_data(run, suites)]
    if other:
        texts.append(_OTHER_DATA.format(suites=", ".join(map(ability_title, dict.fromkeys(other)))))
    for model in dict.fromkeys(model for suite in suites.values() for model in suite.models):
        cells = _published_cells(model, suites)
        found = tuple(cell_of(cells, column) for column in columns)
        if any(cell.percent is not None for cell in found):
            covered = together(suite.coverage(model) for suite in suites.values() if model in suite.models)
            yield Row(model, source, found, covered, tuple(notes.number(text) for text in texts))


def _is_on_other_data(run: RunSummary, suites: Mapping[Ability, PublishedSuite]) -> bool:
    suite = suites.get(run.key.ability)
    return suite is not None and run.data_sha256 != (suite.data_sha256,)


def _published_cells(model: str, suites: Mapping[Ability, PublishedSuite]) -> Cells:
    cells: dict[tuple[Ability | None, str], Cell] = {
        (ability, metric): Cell(rate.percent, rate, coverage=suite.coverage(model))
        for ability, suite in suites.items()
        if model in suite.models
        for metric, rate in suite.rates(model).items()
    }
    percents = {(a, metric): cell.percent for (a, metric), cell in cells.items() if a}
    cells[None, AVERAGE] = Cell(average_performance(percents))
    return cells
