"""The rows that need no run: of the paper's models, as it prints them or scored by us, and of null models.

The paper's figures are of one protocol, and stand only beside runs under it. Beside runs under another one
stand the published answers, scored under that protocol.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from eai.abilities.protocol import Ability, Protocol
from eai.report.row import Cell, Cells, Notes, Row, RowSource, cell_of
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ColumnSpec, ability_title
from eai.results.average import AVERAGE, average_performance
from eai.results.coverage import together
from eai.results.paper_tables import PaperColumn, PaperTable, paper_models
from eai.results.published_scores import (
    NULL_MODELS,
    PublishedScores,
    PublishedSuite,
    null_scores,
    published_scores,
    published_scores_sha256,
)

_PUBLISHED = (
    "Answers that the paper's authors published, scored by us under this protocol (table {sha256:.12}): "
    "those of {known} of the paper's {all} models; the others are to be added."
)
_FLOOR = "Floor: what is earned without deciding anything, by null models; never ranked. {told}."
_OTHER_DATA = "Scored against other data than the runs: {suites}."


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
    told = "; ".join(f"{model} {deed}" for model, deed in NULL_MODELS.items())
    return _scored_rows(suites, columns, runs, notes, RowSource.FLOOR, _FLOOR.format(told=told))


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
