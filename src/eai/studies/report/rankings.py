"""Make rankings: tables of our models and the paper's models, ranked, best numbers in bold, footnotes.

A ranking belongs to one domain under one protocol (scoring rules); readers see it as a `Table`. There are
rankings for the paper's main tables, for experiments, and for the paper's other tables. The other tables
compare, for example, runs with and without replanning. They keep the paper's order, in which compared rows
follow each other.

Rows are runs, the paper's models and null models. The paper's printed numbers appear only beside runs under
the paper's protocol. Beside runs under another protocol, the paper's models have the scores of their
published answers under that protocol.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Literal, TypeAlias, get_args

from eai.abilities.declaration import MetricColumn
from eai.abilities.experiment import Experiment
from eai.abilities.protocol import Ability, Protocol
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results import paper_tables
from eai.results.certainty import (
    ConfidenceIntervals,
    TaskRateContributions,
    compute_intervals_of_weighted_mean,
)
from eai.results.coverage import TaskCoverageByAnswers, combine_coverage
from eai.results.paper_tables import PaperColumn, PaperTable, ScoresOfPublishedAnswers
from eai.results.rate import Rate
from eai.results.summary import (
    AVERAGE,
    AbilityMetric,
    compute_average_performance,
    compute_weights_of_averaged_metrics,
)
from eai.results.table import NO_NUMBER, Cell, Column, Estimate, Table, TextCell
from eai.studies.report.run_summary import RunSummary
from eai.studies.report.table_specs import (
    TableSpec,
    find_paper_column,
    find_table_spec,
    format_ability_title,
    get_columns,
    make_table_specs,
)


@dataclass(frozen=True, slots=True)
class RankedScore(Estimate):
    """A score of a model in a ranking.

    Attributes:
        certainty: the interval and the effective number of tasks; None for numbers printed in the paper.
        texts: texts of the footnotes on this score, without the numbers that they get in the ranking.
        coverage: how many tasks of the suites are answered; None for numbers printed in the paper.
    """

    certainty: ConfidenceIntervals | None = None
    texts: tuple[str, ...] = ()
    coverage: TaskCoverageByAnswers | None = None

    @property
    def may_be_ranked(self) -> bool:
        """Whether the number may be compared with other rows, because enough tasks are answered."""
        return self.coverage is None or self.coverage.is_complete_enough_for_ranking


RowSource: TypeAlias = Literal["run", "paper", "published", "floor"]
"""Source of a row's numbers. Rows of equal rank are sorted by source in this order.

- run: a run.
- paper: the numbers printed in the paper.
- published: the published answers of one of the paper's models, scored by us.
- floor: a null model, a baseline such as empty answers.
"""


@dataclass(frozen=True, slots=True)
class RankedModel:
    """A row of a ranking: the scores of one model.

    Attributes:
        scores: column -> score.
        coverage: how many tasks of the suites are answered; None for numbers printed in the paper.
        harness: name of the program (harness) that connects the model to the world in which it acts.
        effort: the model's reasoning effort.
        notes: texts of the footnotes on the whole row.
        rank: rank by the ranking's primary column; equal scores share a rank. None without a score in this
            column, or if too few tasks are answered.
    """

    model: str
    source: RowSource
    scores: Mapping[MetricColumn, RankedScore]
    coverage: TaskCoverageByAnswers | None = None
    notes: tuple[str, ...] = ()
    rank: int | None = None
    harness: str = ""
    effort: str = ""

    @property
    def may_be_ranked(self) -> bool:
        """Whether the row may have a rank, and its numbers may be marked as the best.

        Rows of null models may not, nor rows of runs that are not ranked
        (`TaskCoverageByAnswers.is_complete_enough_for_ranking`).
        """
        return self.source != "floor" and (
            self.coverage is None or self.coverage.is_complete_enough_for_ranking
        )

    @property
    def all_notes(self) -> list[str]:
        """Texts of the footnotes on the row and on its numbers."""
        return [*self.notes, *(note for score in self.scores.values() for note in score.texts)]

    def make_table_cells(self, ranking: Ranking) -> tuple[Cell, ...]:
        """Return the cells of the row in the table: those of `_FIRST_COLUMNS`, then the row's scores."""
        origin = "" if self.source == "run" else self.source
        answered = NO_NUMBER if self.coverage is None else str(self.coverage)
        numbers = [
            replace(score, notes=ranking.find_footnote_numbers(score.texts)) for score in self.scores.values()
        ]
        model = TextCell(self.model, origin=origin, notes=ranking.find_footnote_numbers(self.notes))
        return (self.rank, model, self.harness, self.effort, answered, *numbers)


ScoresByMetric = Mapping[tuple["Ability | None", str], RankedScore]
"""Scores of one model in one domain, by ability (None for the average) and metric."""


def get_score(scores: ScoresByMetric, column: MetricColumn) -> RankedScore:
    """Return a model's score in a column, or an empty score."""
    return scores.get((column.ability, column.metric), RankedScore(None))


@dataclass(frozen=True, slots=True)
class Ranking:
    """One table of ranked models, for one domain (benchmark) under one protocol (scoring rules).

    Attributes:
        columns: the columns with a number in some row, each with the texts of its footnotes.
        rows: the rows, by rank.
        notes: texts of all footnotes; the first footnote has number 1.
        primary: the column by which rows are ranked, even if it is not shown; None for a table without ranks.
    """

    name: str
    title: str
    protocol: Protocol
    domain: str
    columns: Mapping[MetricColumn, tuple[str, ...]]
    rows: tuple[RankedModel, ...]
    notes: tuple[str, ...]
    primary: MetricColumn | None = None

    def find_footnote_numbers(self, notes: Iterable[str]) -> tuple[int, ...]:
        """Return the numbers by which a table refers to some footnotes, sorted."""
        return tuple(sorted({self.notes.index(note) + 1 for note in notes}))

    @property
    def rank_column_caption(self) -> str:
        """Text for a caption that names the column by which rows are ranked; empty without ranks."""
        if self.primary is None:
            return ""
        groups = [column.group for column in (*self.columns, self.primary)]
        return f", ranked by {_make_short_heading(self.primary, groups)}"

    def make_table(self) -> Table:
        """Return the ranking as a table. Only our numbers have intervals, because the paper prints none.

        The caption (`Table.definition`) has no final full stop, because pages add words to its last sentence.
        """
        groups = [column.group for column in self.columns]
        columns = [
            Column(
                column.metric,
                column.label,
                column.group,
                _make_short_heading(column, groups),
                1,
                True,
                self.find_footnote_numbers(notes),
            )
            for column, notes in self.columns.items()
        ]
        table = Table(
            self.name,
            self.title,
            self._make_caption_of_ranking(),
            (*_FIRST_COLUMNS, *columns),
            tuple([row.make_table_cells(self) for row in self.rows]),
            notes=self.notes,
        )
        unused = {name for name in _AGENT_COLUMNS if not any(getattr(row, name) for row in self.rows)}
        return table.drop_columns(unused)

    def _make_caption_of_ranking(self) -> str:
        """Return the caption.

        It names the protocol (scoring rules), unless all rows are printed in the benchmark's paper.
        """
        title = f"{self.title}, {get_title(self.domain)}"
        if all(row.source == "paper" for row in self.rows):
            return f"{title}. Percent{self.rank_column_caption}"
        return f"{title}, protocol {self.protocol.value}. Percent{self.rank_column_caption}"


_FIRST_COLUMNS = (
    Column("rank", "#", is_number=True),
    Column("model", "Model", heading_without_group="model", is_number=False),
    Column("harness", "Harness", heading_without_group="harness", is_number=False),
    Column("effort", "Effort", heading_without_group="effort", is_number=False),
    Column("answered", "Answered", heading_without_group="answered", is_number=True),
)
"""Columns to the left of a row's scores."""

_AGENT_COLUMNS = ("harness", "effort")
"""Names of columns that a table leaves out if no row has a value in them."""


def _make_short_heading(column: MetricColumn, groups_in_table: Sequence[str]) -> str:
    """Return a column's label, with the group's name in front if the label alone is ambiguous."""
    ambiguous = len(set(groups_in_table)) > 1 and column.label in (
        "P",
        "R",
        "F1",
        "Task",
        "Execution",
        "Planner",
    )
    is_incomplete = column.label in ("State", "Relation", "Action", "Total")
    return f"{column.group}: {column.label}" if ambiguous or is_incomplete else column.label


def choose_ranking_column(metrics: Sequence[str], columns: Sequence[MetricColumn]) -> MetricColumn:
    """Return the column by which rows are ranked.

    It is the column of the first of the given metrics that has a column, or else the first column.
    """
    return next((column for name in metrics for column in columns if column.metric == name), columns[0])


def rank_rows(ranking_column: MetricColumn, rows: Sequence[RankedModel]) -> list[RankedModel]:
    """Return the rows sorted by their rank in one column, with the best number of each column marked."""
    ranks = compute_ranks(
        [_round_score(row.scores[ranking_column]) if row.may_be_ranked else None for row in rows]
    )
    marked, order = zip(mark_best(rows), ranks, strict=True), get_args(RowSource)
    return sorted(
        (replace(row, rank=rank) for row, rank in marked),
        key=lambda row: (row.rank is None, row.rank or 0, order.index(row.source), row.model),
    )


def compute_ranks(values: Sequence[float | None]) -> list[int | None]:
    """Return the rank of each value: 1 for the greatest, and None for no value. Equal values share a rank."""
    numbers = [value for value in values if value is not None]
    return [None if value is None else 1 + sum(other > value for other in numbers) for value in values]


def mark_best(rows: Sequence[RankedModel]) -> list[RankedModel]:
    """Return the rows with the best number of each column marked. A single number is not marked."""
    best: dict[MetricColumn, float] = {}
    for column in dict.fromkeys(column for row in rows for column in row.scores if column.more_is_better):
        values = [
            number for row in rows if (number := _get_value_if_ranked(row, row.scores[column])) is not None
        ]
        best |= {column: max(values)} if len(values) > 1 else {}
    return [
        replace(
            row,
            scores={
                column: _mark_if_best(row, score, best.get(column)) for column, score in row.scores.items()
            },
        )
        for row in rows
    ]


def _mark_if_best(row: RankedModel, score: RankedScore, best: float | None) -> RankedScore:
    return replace(score, best=best is not None and _get_value_if_ranked(row, score) == best)


def _get_value_if_ranked(row: RankedModel, score: RankedScore) -> float | None:
    return _round_score(score) if score.may_be_ranked and row.source != "floor" else None


def _round_score(score: RankedScore) -> float | None:
    return None if score.value is None else round(score.value, 1)


_FLOOR = "Floor: what is earned without deciding anything, by null models; never ranked. {models}."
_OTHER_DATA = "Scored against other data than the runs: {suites}."


def _make_note_on_trivial_baselines(models: Iterable[str]) -> str:
    descriptions = paper_tables.NULL_MODELS | paper_tables.NULL_AGENTS
    return _FLOOR.format(models="; ".join([f"{model} {descriptions[model]}" for model in models]))


def make_run_rows(
    columns: Sequence[MetricColumn],
    runs: Sequence[RunSummary],
    scores_by_run: Mapping[str, ScoresByMetric],
    *,
    table_has_paper_rows: bool = False,
) -> Iterator[RankedModel]:
    """Yield a row for each model that has a number in at least one column, with notes on missing answers.

    Args:
        columns: the columns.
        runs: the runs of one protocol and domain.
        scores_by_run: all scores of each model, by the name of the run.
        table_has_paper_rows: whether the table also has rows of the paper. A footnote then names our planner,
            because the paper used another planner to judge operators.
    """
    abilities = {column.ability for column in columns}
    planners = {name for run in runs for name in run.planners}
    for name, scores in scores_by_run.items():
        row = {column: get_score(scores, column) for column in columns}
        if any(score.value is not None for score in row.values()):
            shown = [run for run in runs if run.key.name == name and run.key.ability in abilities]
            remarks = [
                f"{format_ability_title(run.key.ability)}: {run.coverage.remark_on_missing_answers}"
                for run in shown
                if run.coverage.remark_on_missing_answers
            ]
            if len(planners) > 1 or table_has_paper_rows:
                judged = [", ".join(run.planners) for run in shown if run.planners]
                remarks += [f"Planner that judged operators: {names}." for names in judged]
            model, experiment = shown[0].key.model, shown[0].key.experiment or Experiment()
            source: RowSource = "floor" if paper_tables.is_trivial_baseline(model) else "run"
            yield RankedModel(
                model,
                source,
                row,
                combine_coverage(run.coverage for run in shown),
                tuple(remarks),
                harness=experiment.harness or "",
                effort=experiment.effort or "",
            )


def make_scores_by_model(runs: Sequence[RunSummary]) -> dict[str, ScoresByMetric]:
    """Return all scores of runs of one domain and protocol, by run, with averages over abilities."""
    by_name: dict[str, ScoresByMetric] = {}
    for name, items in group_pairs((item.key.name, item) for item in runs).items():
        scores: dict[tuple[Ability | None, str], RankedScore] = {
            (item.key.ability, metric): _make_score(
                rate.percent, item.certainties[metric], item.coverage, rate
            )
            for item in items
            for metric, rate in item.rates.items()
        }
        cases = {(item.key.ability, metric): of for item in items for metric, of in item.cases.items()}
        scores[None, AVERAGE] = _average_scores_over_abilities(
            scores, cases, combine_coverage(item.coverage for item in items)
        )
        by_name[name] = scores
    return by_name


def _average_scores_over_abilities(
    scores: ScoresByMetric,
    cases: Mapping[AbilityMetric, TaskRateContributions],
    coverage: TaskCoverageByAnswers | None,
) -> RankedScore:
    percents = _get_percents(scores)
    percent = compute_average_performance(percents)
    if percent is None:
        return RankedScore(None, coverage=coverage)
    weighted = [
        (weight, cases[metric]) for metric, weight in compute_weights_of_averaged_metrics(percents).items()
    ]
    return _make_score(percent, compute_intervals_of_weighted_mean(weighted), coverage)


def _make_score(
    percent: float | None,
    certainty: ConfidenceIntervals | None,
    coverage: TaskCoverageByAnswers | None,
    rate: Rate | None = None,
) -> RankedScore:
    low, high = (None, None) if certainty is None else certainty.interval
    numerator, denominator = (None, None) if rate is None else (rate.numerator, rate.denominator)
    return RankedScore(percent, low, high, numerator, denominator, certainty=certainty, coverage=coverage)


def _get_percents(scores: ScoresByMetric) -> dict[AbilityMetric, float | None]:
    return {(ability, metric): score.value for (ability, metric), score in scores.items() if ability}


def make_paper_rows(
    paper_column_by_column: Mapping[MetricColumn, PaperColumn], printed_tables: Sequence[PaperTable]
) -> Iterator[RankedModel]:
    """Yield a row for each of the paper's models.

    If two tables print a number for a column, the first table counts.
    """
    for model in dict.fromkeys(model for printed_table in printed_tables for model in printed_table.rows):
        scores = {
            column: _make_paper_score(model, place, printed_tables)
            for column, place in paper_column_by_column.items()
        }
        if any(score.value is not None for score in scores.values()):
            yield RankedModel(model, "paper", scores)


def _make_paper_score(model: str, column: PaperColumn, printed_tables: Sequence[PaperTable]) -> RankedScore:
    for printed_table in printed_tables:
        figure = printed_table.find_printed_number(model, column)
        if figure is not None:
            return RankedScore(figure, texts=tuple(printed_table.notes.get((model, column), ())))
    return RankedScore(None)


def _find_column_notes(column: PaperColumn, printed_tables: Sequence[PaperTable]) -> tuple[str, ...]:
    return tuple(
        [note for printed_table in printed_tables for note in printed_table.notes.get(("", column), ())]
    )


def read_ranking_rows_of_shipped_scores(
    columns: Sequence[MetricColumn], runs: Sequence[RunSummary], *, of_trivial_baselines: bool
) -> Iterator[RankedModel]:
    """Yield the rows of a table of models that the package includes. Notes in the table become footnotes.

    Args:
        columns: the columns.
        runs: the runs of one protocol and domain that share a table with these rows. Models without scores
            under that protocol have no rows.
        of_trivial_baselines: True for null models (baselines such as an empty answer), False for the paper's
            models with the scores of their published answers.
    """
    protocol, domain, *_ = runs[0].key
    source: RowSource = "floor" if of_trivial_baselines else "published"
    table = (
        paper_tables.read_trivial_baseline_scores
        if of_trivial_baselines
        else paper_tables.read_published_scores
    )(protocol.value)
    abilities = dict.fromkeys(column.ability for column in columns if column.ability)
    suites = {a: table.suites[f"{domain}/{a}"] for a in abilities if f"{domain}/{a}" in table.suites}
    models = dict.fromkeys(model for suite in suites.values() for model in suite.models)
    texts = [
        _make_note_on_trivial_baselines(models)
        if of_trivial_baselines
        else _make_note_on_published_answers(protocol.value, len(models))
    ]
    texts += [note for suite in suites.values() for note in suite.notes]
    pairs = [(run, suites[run.key.ability]) for run in runs if run.key.ability in suites]
    other = [run.key.ability for run, suite in pairs if run.data_sha256 != (suite.data_sha256,)]
    if other:
        texts.append(_OTHER_DATA.format(suites=", ".join(map(format_ability_title, dict.fromkeys(other)))))
    for model in models:
        scores = _make_published_scores(model, suites)
        row = {column: get_score(scores, column) for column in columns}
        if any(score.value is not None for score in row.values()):
            covered = combine_coverage(
                suite.find_coverage(model) for suite in suites.values() if model in suite.models
            )
            yield RankedModel(model, source, row, covered, tuple(texts))


def _make_note_on_published_answers(protocol: str, model_count: int) -> str:
    """Return the footnote on rows whose scores are those of published answers."""
    sha256 = paper_tables.hash_published_scores(protocol)
    of_paper = len({*paper_tables.map_files_to_paper_models().values()})
    return (
        f"Answers that the paper's authors published, scored by us under this protocol (table {sha256:.12}): "
        f"those of {model_count} of the paper's {of_paper} models."
    )


def _make_published_scores(model: str, suites: Mapping[Ability, ScoresOfPublishedAnswers]) -> ScoresByMetric:
    scores: dict[tuple[Ability | None, str], RankedScore] = {
        (ability, metric): _make_score(rate.percent, None, suite.find_coverage(model), rate)
        for ability, suite in suites.items()
        if model in suite.models
        for metric, rate in suite.find_rates(model).items()
    }
    scores[None, AVERAGE] = RankedScore(compute_average_performance(_get_percents(scores)))
    return scores


_LEFT_OUT = (
    "Runs under another protocol than `eai-1.0.5` count otherwise and are not set beside these figures."
)


def make_rankings(runs: Sequence[RunSummary], *, with_paper: bool) -> list[Ranking]:
    """Return the tables of all runs by protocol (scoring rules) and domain, ordered as the paper's tables.

    Args:
        runs: the runs, sorted by the order of their keys.
        with_paper: whether the paper's models appear beside ours.
    """
    return [
        table
        for group in group_pairs((item.key[:2], item) for item in runs).values()
        for numbers in [make_scores_by_model(group)]
        for spec in make_table_specs(item.key.ability for item in group)
        if (table := make_ranking(spec, group, numbers, with_paper=with_paper))
    ]


def make_ranking(
    spec: TableSpec, runs: Sequence[RunSummary], numbers: Mapping[str, ScoresByMetric], *, with_paper: bool
) -> Ranking | None:
    """Return a table of runs of one domain and protocol (scoring rules), or None if it has no numbers.

    Rows with printed rates of the paper appear only in the table of the paper's protocol. Under other
    protocols, the paper's models have the scores that this package gives their published answers. Null models
    (trivial built-in models) come last, without a rank.

    Args:
        spec: name and columns of the table.
        runs: the runs.
        numbers: all scores of the runs (`make_scores_by_model`).
        with_paper: whether the paper's models appear beside ours.
    """
    columns = tuple(
        column
        for column in spec.columns
        if any(get_score(scores, column).value is not None for scores in numbers.values())
    )
    if not columns:
        return None
    protocol, domain = runs[0].key[:2]
    by = choose_ranking_column(spec.primary, columns)
    ours = [
        _add_note_on_missing_rank(row, by)
        for row in make_run_rows(columns, runs, numbers, table_has_paper_rows=with_paper)
    ]
    places = {column: find_paper_column(column, domain) for column in columns}
    printed_tables, others = [], list[RankedModel]()
    if with_paper and protocol.value == paper_tables.read_paper_protocol_and_tables().protocol:
        printed_tables = [
            paper_tables.read_paper_table(name)
            for name in paper_tables.read_paper_protocol_and_tables().tables[spec.name]
        ]
    elif with_paper:
        others += read_ranking_rows_of_shipped_scores(columns, runs, of_trivial_baselines=False)
    others += [
        *make_paper_rows(places, printed_tables),
        *read_ranking_rows_of_shipped_scores(columns, runs, of_trivial_baselines=True),
    ]
    on_columns = {column: _find_column_notes(place, printed_tables) for column, place in places.items()}
    notes = _merge_notes(_list_notes_of_rows(ours), *on_columns.values(), _list_notes_of_rows(others))
    rows = tuple(rank_rows(by, [*ours, *others]))
    return Ranking(spec.name, spec.title, protocol, domain, on_columns, rows, notes, by)


def _merge_notes(*notes: Iterable[str]) -> tuple[str, ...]:
    """Return the texts of footnotes, each once, in the order in which rows first use them."""
    return tuple(dict.fromkeys(chain(*notes)))


def _list_notes_of_rows(rows: Iterable[RankedModel]) -> list[str]:
    return [note for row in rows for note in row.all_notes]


def _add_note_on_missing_rank(row: RankedModel, ranking_column: MetricColumn) -> RankedModel:
    """Return the row, with a footnote on unanswered abilities if it has no number to rank by."""
    if row.scores[ranking_column].value is not None:
        return row
    lacking = [column for column, score in row.scores.items() if score.value is None]
    missing = dict.fromkeys(
        [format_ability_title(column.ability).lower() for column in lacking if column.ability]
    )
    unasked = f": {', '.join(missing)} not asked" if missing else ""
    note = f"No rank, as there is no {ranking_column.label.lower()}{unasked}."
    return replace(row, notes=(*row.notes, note))


def make_experiment_rankings(runs: Sequence[RunSummary]) -> list[Ranking]:
    """Return a table of experiments (runs with study options) for each suite that has experiments.

    A table has only models with experiments. The plain run of a model comes above its experiments.

    Args:
        runs: the runs, including plain runs, sorted by the order of their keys.
    """
    suites = group_pairs((item.key[:3], item) for item in runs).values()
    return [table for group in suites if (table := _make_experiment_ranking(group)) is not None]


def _make_experiment_ranking(runs: Sequence[RunSummary]) -> Ranking | None:
    models = {item.key.model for item in runs if not item.key.has_standard_rules_and_no_study_options}
    shown = [item for item in runs if item.key.model in models]
    if not shown:
        return None
    key = shown[0].key
    spec = find_table_spec(key.ability)
    rows = tuple(
        [
            replace(row, model=item.key.name, harness="", effort="")
            for item in shown
            for row in make_run_rows(spec.columns, [item], make_scores_by_model([item]))
        ]
    )
    name, title = f"experiments_{spec.name}", f"Experiments: {format_ability_title(key.ability).lower()}"
    columns, notes = dict.fromkeys(spec.columns, ()), _merge_notes(_list_notes_of_rows(rows))
    return Ranking(name, title, key.protocol, key.domain, columns, rows, notes)


def make_rankings_of_secondary_paper_tables(runs: Sequence[RunSummary]) -> list[Ranking]:
    """Return the paper's tables other than the main tables, with comparable runs above the paper's rows.

    Each table has one ranking for each domain. They come in the paper's order.

    Args:
        runs: the runs, sorted by the order of their keys.
    """
    printed_tables = map(paper_tables.read_paper_table, paper_tables.read_paper_protocol_and_tables().others)
    return [
        _make_ranking_of_secondary_paper_table(printed_table, domain, runs)
        for printed_table in printed_tables
        for domain in dict.fromkeys(column.domain for column in printed_table.columns)
    ]


def _make_ranking_of_secondary_paper_table(
    printed_table: PaperTable, domain: str, runs: Sequence[RunSummary]
) -> Ranking:
    setting = paper_tables.read_paper_protocol_and_tables()
    all_columns = get_columns(setting.others[printed_table.name])
    columns = tuple(column for column in all_columns if _has_paper_numbers(printed_table, column, domain))
    abilities = {column.ability for column in columns}
    comparable = [item for item in runs if item.key.domain == domain and item.key.ability in abilities]
    if printed_table.name in setting.other_tasks:
        comparable = []
    places = {column: find_paper_column(column, domain) for column in columns}
    ours = [item for item in comparable if item.key.protocol.value == setting.protocol]
    remarks = (_LEFT_OUT,) if len(ours) < len(comparable) else ()
    on_columns = {
        column: (*remarks, *_find_column_notes(place, [printed_table])) for column, place in places.items()
    }
    rows = [
        *make_run_rows(columns, ours, make_scores_by_model(ours), table_has_paper_rows=True),
        *make_paper_rows(places, [printed_table]),
    ]
    marked, notes = tuple(mark_best(rows)), _merge_notes(*on_columns.values(), _list_notes_of_rows(rows))
    name, protocol = f"paper_{printed_table.name}", Protocol(setting.protocol)
    return Ranking(name, printed_table.title, protocol, domain, on_columns, marked, notes)


def _has_paper_numbers(printed_table: PaperTable, column: MetricColumn, domain: str) -> bool:
    return any(
        printed_table.find_printed_number(model, find_paper_column(column, domain)) is not None
        for model in printed_table.rows
    )
