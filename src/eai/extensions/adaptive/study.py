"""Analyze tasks as test items: their difficulty, how well they separate models, and odd results."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import InputError
from eai.base.grouping import group_pairs
from eai.extensions.adaptive.flag import Flag, FlagReader
from eai.extensions.adaptive.rasch import (
    RaschModel,
    compute_item_rest_correlations,
    estimate_reliability,
    fit_rasch,
)
from eai.results.certainty import LEVEL, compute_student_quantile
from eai.results.lines import (
    SUITE,
    AnswerTableLine,
    SuiteKey,
    compute_contribution_to_main_score,
    group_by_suite,
    make_task_rate_contribution,
)
from eai.results.paper_tables import is_trivial_baseline
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    RULE,
    clip_label,
    draw_estimate,
    get_value_of_cell,
    group_rows_by_suite,
    make_figure,
)
from eai.results.rate import Rate
from eai.results.table import Cell, Estimate, Row, Table, collect_rows_in_table
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Figures, Study, make_file_name_and_titled_suite_figure
from eai.tasks.options import Options

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


MIN_MODELS = 3
_FOLDS = 10


@dataclass(frozen=True)
class SuiteScores:
    """The scores of all models in one ability and benchmark, for the tasks that all models answered.

    Attributes:
        models: the names of the models, in the order of the rows of ``matrix``.
        tasks: the ids of the tasks, in the order of the columns of ``matrix``.
        names: name of each task. Near copies share a name.
        matrix: the scores, from 0 to 1: a row for each model, a column for each task.
    """

    models: tuple[str, ...]
    tasks: tuple[str, ...]
    names: tuple[str, ...]
    matrix: Matrix

    @property
    def has_enough_models_and_tasks(self) -> bool:
        """Whether there are at least `MIN_MODELS` models, and at least one task."""
        return len(self.models) >= MIN_MODELS and bool(self.tasks)

    @cached_property
    def rasch(self) -> RaschModel:
        """The Rasch model fitted to the scores."""
        return fit_rasch(self.matrix)

    @cached_property
    def item_rest_correlations(self) -> Matrix:
        """Correlation of each task's score with the sum of the scores of all other tasks."""
        return compute_item_rest_correlations(self.matrix)


def collect_scores(answers: Sequence[AnswerTableLine]) -> SuiteScores:
    """Return the scores of the answers to one suite. An unreadable answer scores 0."""
    import numpy as np

    by_model: dict[str, dict[str, float]] = {}
    names: dict[str, str] = {}
    for answer in answers:
        if answer.outcome != AnswerOutcome.EXCLUDED.value:
            by_model.setdefault(answer.model_harness_and_effort, {})[answer.task] = (
                Rate(*compute_contribution_to_main_score(answer)).share or 0.0
            )
            names[answer.task] = answer.name
    tasks = [task for task in names if all(task in scores for scores in by_model.values())]
    matrix = np.array([[scores[task] for task in tasks] for scores in by_model.values()])
    return SuiteScores(tuple(by_model), tuple(tasks), tuple(names[task] for task in tasks), matrix)


_ScoredSuites: TypeAlias = Mapping[SuiteKey, tuple[Sequence[AnswerTableLine], SuiteScores]]


def make_task_difficulty_tables(answers: Sequence[AnswerTableLine], flags: FlagReader) -> list[Table]:
    """Return the tables of the analysis, for suites with answers of at least `MIN_MODELS` models.

    Args:
        answers: the answers of all models. Null models (baselines such as an empty answer) are left out.
        flags: yields the flags of a task: reasons to use its answers with caution.
    """
    of_models = group_by_suite([each for each in answers if not is_trivial_baseline(each.model)])
    scored = {suite: (given, collect_scores(given)) for suite, given in of_models.items()}
    suites = {suite: each for suite, each in scored.items() if each[1].has_enough_models_and_tasks}
    items = _make_tasks_table(suites, flags)
    return [
        _make_suite_measurement_quality_table(suites),
        _make_abilities_table(suites),
        _make_table_of_tasks_to_inspect(items),
        items,
    ]


def compute_held_out_auc_of_rasch_and_mean_score(scores: SuiteScores) -> tuple[float | None, float | None]:
    """Return how well the Rasch model, and how well the models' mean scores, predict held-out answers.

    Both values are areas under the ROC curve. Each answer is predicted from the nine tenths of all answers
    that do not contain it. Both are None if a score is neither 0 nor 1.
    """
    import numpy as np

    matrix = scores.matrix
    if not np.isin(matrix, (0.0, 1.0)).all():
        return None, None
    order = np.random.default_rng(0).permutation(matrix.size).reshape(matrix.shape)
    chances, means = np.zeros(matrix.shape), np.zeros(matrix.shape)
    for fold in range(_FOLDS):
        out = order % _FOLDS == fold
        kept = np.where(out, np.nan, matrix)
        chances[out] = fit_rasch(kept).predict_success()[out]
        means[out] = np.broadcast_to(np.nanmean(kept, axis=1, keepdims=True), matrix.shape)[out]
    return _compute_area_under_curve(matrix, chances), _compute_area_under_curve(matrix, means)


def _compute_area_under_curve(success: Matrix, predicted: Matrix) -> float | None:
    """Return the probability that a random success has a higher prediction than a random failure."""
    from scipy.stats import rankdata

    yes = success.ravel() == 1
    wins, losses = int(yes.sum()), int((~yes).sum())
    if not wins or not losses:
        return None
    ranks = rankdata(predicted.ravel().round(9))
    return _round_to_six_digits(float((ranks[yes].sum() - wins * (wins + 1) / 2) / (wins * losses)))


def estimate_model_ability_above_mean(scores: SuiteScores, model_index: int) -> Estimate:
    """Return a model's ability minus the mean of all models, in logits, with its confidence interval.

    The variance comes from a first-order jackknife that takes difficulties as exact. The jackknife leaves
    out all tasks with one name at a time, because near copies of a task have the same name. If the variance
    for independent tasks is larger, it is used instead.

    Args:
        scores: the scores of all models.
        model_index: index of the model, counted from 0.
    """
    import numpy as np

    fitted = scores.rasch
    p = fitted.predict_success()
    weights, residuals = p * (1 - p), scores.matrix - p
    information = weights.sum(axis=1) + 1
    value = float(fitted.abilities[model_index] - fitted.abilities.mean())
    places = {name: number for number, name in enumerate(dict.fromkeys(scores.names))}
    if len(places) < 2:
        return Estimate(_round_to_six_digits(value))
    columns = [places[name] for name in scores.names]
    residual_sums = np.array([np.bincount(columns, row, len(places)) for row in residuals])
    weight_sums = np.array([np.bincount(columns, row, len(places)) for row in weights])
    changes = -residual_sums / (information[:, None] - weight_sums)
    own = changes[model_index] - changes.mean(axis=0)
    share = np.full(len(information), -1 / len(information))
    share[model_index] += 1
    by_name = (len(places) - 1) / len(places) * float((own * own).sum())
    by_task = float((share * share / information).sum())
    half = compute_student_quantile(LEVEL, len(places) - 1) * math.sqrt(max(by_name, by_task))
    return Estimate(
        _round_to_six_digits(value), _round_to_six_digits(value - half), _round_to_six_digits(value + half)
    )


def _find_task_score_flags(task_scores: Matrix, item_rest_correlation: float) -> Iterator[Flag]:
    if task_scores.sum() >= len(task_scores) - 1:
        yield "saturated"
    if item_rest_correlation < 0:
        yield "negative"


def _map_tasks_to_most_frequent_failed_check(answers: Sequence[AnswerTableLine]) -> Mapping[str, str]:
    """Return a mapping from task to the check that fails first for most models.

    Unreadable answers do not count.
    """
    checks_of_task = group_pairs(
        (a.task, a.error_check) for a in answers if a.error_check is not None and a.error_kind != "parsing"
    )
    return {task: min(checks, key=lambda c: (-checks.count(c), c)) for task, checks in checks_of_task.items()}


def _round_to_six_digits(number: float) -> float | None:
    """Return a number rounded to six decimals, because machines differ in further ones. NaN becomes None."""
    return None if math.isnan(number) else round(number, 6)


def _to_int_or_rounded(number: float) -> float:
    return int(number) if number == int(number) else round(number, 6)


@collect_rows_in_table(
    "tests",
    (
        *(*SUITE, "models", "tasks", "saturated", "unsolved", "negative", "alpha"),
        *("held_out_rasch", "held_out_mean"),
    ),
)
def _make_suite_measurement_quality_table(suites: _ScoredSuites) -> Iterator[Row]:
    """Suites as tests of models.

    saturated: tasks that all models solve, or all but one; unsolved: tasks that no model solves; negative:
    tasks on which better models do worse; alpha: Cronbach's alpha over models. The last two columns rate
    predictions of held-out answers: the probability that a prediction is higher for a right answer than for
    a wrong answer. held_out_rasch: predictions from ability and difficulty; held_out_mean: predictions from
    the model's mean score only.
    """
    for suite, (_, scores) in suites.items():
        models = len(scores.models)
        solved = scores.matrix.sum(axis=0)
        alpha = estimate_reliability(scores.matrix)
        counts = [solved >= models - 1, solved == 0, scores.item_rest_correlations < 0]
        saturated, unsolved, negative = (int(of_task.sum()) for of_task in counts)
        rounded = None if alpha is None else _round_to_six_digits(alpha)
        yield (
            *(*suite, models, len(scores.tasks), saturated, unsolved, negative, rounded),
            *compute_held_out_auc_of_rasch_and_mean_score(scores),
        )


@collect_rows_in_table("abilities", (*SUITE, "answered_by", "logit", "score"))
def _make_abilities_table(suites: _ScoredSuites) -> Iterator[Row]:
    """Abilities of models.

    The column logit is the ability by the Rasch model: a model of ability t solves a task of difficulty b
    with probability 1 / (1 + exp(b - t)); the models' mean is 0. Intervals come from a jackknife that leaves
    out all tasks with one name at a time, because near copies of a task share a name. The jackknife takes
    difficulties as exact. The score is the mean over all tasks.
    """
    for suite, (answers, scores) in suites.items():
        abilities = scores.rasch.abilities
        for place in sorted(range(len(scores.models)), key=lambda place: -abilities[place]):
            model = scores.models[place]
            cases = [
                make_task_rate_contribution(line, compute_contribution_to_main_score(line))
                for line in answers
                if line.model_harness_and_effort == model
            ]
            yield (
                *suite,
                model,
                estimate_model_ability_above_mean(scores, place),
                Estimate.from_task_rate_contributions(cases),
            )


_ITEM = (
    *(*SUITE, "task", "name", "solved", "models", "difficulty", "difficulty_error"),
    *("item_rest", "check", "flags"),
)


@collect_rows_in_table("flagged", _ITEM)
def _make_table_of_tasks_to_inspect(items: Table) -> Iterable[Row]:
    """Tasks to inspect.

    A task is listed for one of three reasons: no model solves it; worse models solve it and better models do
    not; or its goals demand the same of two objects that have one name in answers. item_rest: the correlation
    over models with the score in all other tasks; check: the check that most models fail first.
    """
    return [row for row in items.rows if row[-1] and row[-1] != "saturated"]


@collect_rows_in_table("items", _ITEM, max_shown_rows=0)
def _make_tasks_table(suites: _ScoredSuites, flags: FlagReader) -> Iterator[Row]:
    """All tasks.

    For each task: how many models solve it (or the sum of their F1), its difficulty with standard error, its
    agreement with the other tasks, and its flags.
    """
    for suite, (answers, scores) in suites.items():
        fitted, checks = scores.rasch, _map_tasks_to_most_frequent_failed_check(answers)
        for place, task in enumerate(scores.tasks):
            column, agreement = scores.matrix[:, place], float(scores.item_rest_correlations[place])
            yield (
                *suite,
                task,
                scores.names[place],
                _to_int_or_rounded(float(column.sum())),
                len(column),
                _round_to_six_digits(float(fitted.difficulties[place] - fitted.abilities.mean())),
                _round_to_six_digits(float(fitted.difficulty_errors[place])),
                _round_to_six_digits(agreement),
                checks.get(task),
                ", ".join(
                    [*_find_task_score_flags(column, agreement), *flags(suite, task, bool(column.max() == 0))]
                ),
            )


def _analyze_task_difficulties(records: StudyRecords, chosen: Options) -> Iterator[Analysis]:
    from eai.extensions.adaptive.item_flags import make_function_that_flags_doubtful_tasks

    tables = make_task_difficulty_tables(
        records.make_tidy_tables_of_comparable_runs().answers,
        make_function_that_flags_doubtful_tasks(records.source),
    )
    if not tables[0].rows:
        raise InputError(f"expected answers of at least {MIN_MODELS} models to one suite")
    yield Analysis(tables, _draw_figures(tables))


def _draw_figures(tables: Sequence[Table]) -> Figures:
    abilities = group_rows_by_suite(tables[1])
    for suite, rows in group_rows_by_suite(tables[3]).items():
        yield make_file_name_and_titled_suite_figure(
            suite, "items", draw_difficulties_and_abilities(rows, abilities[suite])
        )


_BINS_PER_UNIT = 2


def draw_difficulties_and_abilities(
    items: Sequence[Mapping[str, Cell]], models: Sequence[Mapping[str, Cell]]
) -> Figure | None:
    """Draw a histogram of task difficulties and, below it on the same scale, the abilities of the models.

    A test separates models best if their abilities are close to its difficulties. Return None if no task has
    a difficulty.

    Args:
        items: the rows of the table of tasks of a suite.
        models: the rows of the table of models.
    """
    difficulties = [float(row["difficulty"]) for row in items if isinstance(row["difficulty"], float)]
    if not difficulties:
        return None
    figure = make_figure(COLUMN, 1.6 + 0.17 * len(models))
    top, bottom = figure.subplots(
        2, 1, sharex=True, gridspec_kw={"height_ratios": [1.2, 0.35 + 0.17 * len(models)]}
    )
    ends = [get_value_of_cell(row["logit"]) for row in models]
    low, high = min([*difficulties, *ends]) - 0.3, max([*difficulties, *ends]) + 0.3
    width = 1 / _BINS_PER_UNIT
    edges = [width * step for step in range(int(low / width) - 1, int(high / width) + 2)]
    top.hist(difficulties, bins=edges, color=MUTED, edgecolor="white", linewidth=0.6)
    top.set_ylabel("tasks", fontsize=7)
    top.grid(axis="y", color=RULE, linewidth=0.6)
    top.set_axisbelow(True)
    for place, row in enumerate(models):
        cell = row["logit"]
        draw_estimate(bottom, place, cell if isinstance(cell, Estimate) else None, INK, INK)
    bottom.set_yticks(
        range(len(models)), labels=[clip_label(str(row["answered_by"])) for row in models], fontsize=6.5
    )
    bottom.set_ylim(len(models) - 0.5, -0.5)
    bottom.tick_params(axis="y", length=0)
    bottom.grid(axis="x", color=RULE, linewidth=0.6)
    bottom.set_xlabel("difficulty of tasks (above), ability of models", fontsize=7, loc="right")
    return figure


ITEMS = Study(
    "items",
    "Tasks by the answers of many models: difficulty, agreement with other tasks, and odd results.",
    analyze=_analyze_task_difficulties,
    included_in_all=True,
)
