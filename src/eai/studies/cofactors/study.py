"""Study cofactors: features of tasks on which success depends.

The paper ("Correlation with Action Length and Goal Complexity") plots success against six features of a task,
for one model in one suite. This study draws the same curves for all models and suites. It adds a regression
on all features together, since features are correlated: a long plan, for example, involves many objects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from statistics import fmean
from typing import TYPE_CHECKING, TypeAlias

from pydantic import Field

from eai.abilities.explanation import EXECUTED
from eai.abilities.verdict import make_rate_contribution_of_answer
from eai.base.grouping import group_pairs
from eai.benchmarks.features import TaskStatistics
from eai.results.certainty import TaskRateContribution
from eai.results.lines import (
    MEASURES,
    MODEL,
    SUITE,
    AnswerScoreName,
    AnswerTableLine,
    PlanStepTableLine,
    SuiteKey,
    TaskGoalTableLine,
    TidyTableLine,
    group_by_model,
    group_by_run,
    group_by_suite,
    make_task_rate_contribution,
)
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    RULE,
    draw_estimate,
    draw_line,
    draw_rates_by_name,
    group_rows_by_suite,
    make_figure,
)
from eai.results.rate import Rate
from eai.results.table import Cell, Estimate, Row, Table, collect_rows_in_table
from eai.results.tidy import TidyTables
from eai.studies.cofactors.effects import compute_rank_correlation, fit_logistic_regression
from eai.studies.records import StudyRecords
from eai.studies.study import Analysis, Figures, Study, make_file_name_and_titled_suite_figure
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


STEPS = "annotated_steps"

_UNCOMPARED = frozenset({"ground_action_goals", "containers", "hidden", "labels"})
FEATURES = tuple([field.name for field in fields(TaskStatistics) if field.name not in _UNCOMPARED])
"""Names of the features of a task that are compared with scores.

All of them are numbers, such as the number of steps. The features in `_UNCOMPARED` are left out:
`ground_action_goals` always equals `action_goals`, `containers` and `hidden` are about hidden objects, and
`labels` is text.
"""

MIN_TASKS = 5
"""Minimum number of tasks in a bin; tables and figures mark bins with fewer tasks."""

_AnswersBySuite: TypeAlias = Mapping[SuiteKey, Sequence[AnswerTableLine]]
_ShareGetter: TypeAlias = Callable[[AnswerTableLine], Share]

_MAX_BINS = 8
_BIN_SIZES = (1, 2, 5)


def _compute_logarithm(number: int | None) -> float | None:
    return math.log(number) if number else None


REGRESSION_COLUMNS: Mapping[str, Callable[[AnswerTableLine], float | None]] = {
    f"log {STEPS}": lambda answer: _compute_logarithm(answer.annotated_steps),
    "ground_relation_goals": lambda answer: answer.ground_relation_goals,
    "ground_state_goals": lambda answer: answer.ground_state_goals,
    "ground_action_goals": lambda answer: answer.ground_action_goals,
    "log objects": lambda answer: _compute_logarithm(answer.objects),
    "any tool_steps": lambda answer: None if answer.tool_steps is None else float(answer.tool_steps > 0),
    "quantified_goals": lambda answer: answer.quantified_goals,
}
"""Mapping from the columns of the regression to functions that compute a column's value for an answer."""


def make_task_feature_tables(tables: TidyTables, *, bin_width: int, measure: AnswerScoreName) -> list[Table]:
    """Return the tables that compare scores with features of tasks.

    Args:
        tables: the tidy tables of the records, such as one with a line for each answer.
        bin_width: width of a bin of plan lengths, in steps of annotated plans; the paper uses 10.
        measure: the score that is compared with features.
    """
    suites, get_share = group_by_suite(tables.answers), MEASURES[measure]
    judged = {
        suite: [answer for answer in answers if get_share(answer).denominator]
        for suite, answers in suites.items()
    }
    return [
        _make_feature_effects_table(suites),
        _make_correlations_table(judged, get_share),
        _make_scores_by_feature_bin_table(judged, get_share, bin_width),
        _make_actions_table(tables.steps),
        _make_predicates_table(tables.goals),
    ]


def make_bin_function(feature: str, values: Iterable[int], width: int) -> Callable[[int], tuple[int, int]]:
    """Return a function that maps a feature's value to the lowest and the highest value of its bin.

    Numbers of annotated steps have bins of the given width. Other features have bins of the smallest width
    of 1, 2, 5, 10, ... that gives at most eight bins. If any value of such a feature is above 1,000, its
    bins are 0, 1, 2-9, 10-99, ...
    """
    highest = max(values, default=0)
    if feature != STEPS:
        if highest > 1000:
            return _find_bin_between_powers_of_ten
        sizes = (nice * 10**power for power in range(4) for nice in _BIN_SIZES)
        width = next(size for size in sizes if highest // size < _MAX_BINS)
    return lambda value: (value // width * width, value // width * width + width - 1)


def _find_bin_between_powers_of_ten(value: int) -> tuple[int, int]:
    if value < 2:
        return value, value
    power = 10 ** int(math.log10(value) + 1e-9)
    return (2, 9) if power == 1 else (power, 10 * power - 1)


@collect_rows_in_table("curves", (*SUITE, MODEL, "feature", "from", "to", "score", "tasks", "few"))
def _make_scores_by_feature_bin_table(
    suites: _AnswersBySuite, get_share: _ShareGetter, bin_width: int, few: int = MIN_TASKS
) -> Iterator[Row]:
    """Score by feature.

    The score (task success; F1 in goal interpretation) of the tasks whose feature is in a bin, both bounds
    included. Bins of annotated steps are {bin_width} wide. For the other features, they have the smallest
    width of 1, 2, 5, 10, ... that gives at most eight bins, or are bounded by powers of ten. Bins without
    tasks are left out; the column `few` marks bins with fewer than {few} tasks. Intervals count tasks with
    the same name as one unit.
    """
    for suite, answers in suites.items():
        models = group_by_model(answers)
        for feature in FEATURES:
            values = {value for line in answers if (value := getattr(line, feature)) is not None}
            if len(values) > 1:
                bin_of = make_bin_function(feature, values, bin_width)
                for model, lines in models.items():
                    pairs = [(value, a) for a in lines if (value := getattr(a, feature)) is not None]
                    binned = group_pairs(
                        (bin_of(value), make_task_rate_contribution(a, get_share(a))) for value, a in pairs
                    )
                    yield from [(*suite, model, feature, *row) for row in _make_feature_bin_rows(binned, few)]


def _make_feature_bin_rows(
    cases_by_bin: Mapping[tuple[int, int], Sequence[TaskRateContribution]], min_tasks: int
) -> Iterator[Row]:
    for (low, high), cases in sorted(cases_by_bin.items()):
        tasks = len({case.task for case in cases})
        yield low, high, Estimate.from_task_rate_contributions(cases), tasks, tasks < min_tasks


@collect_rows_in_table("correlations", (*SUITE, MODEL, "feature", "rho", "tasks"))
def _make_correlations_table(suites: _AnswersBySuite, get_share: _ShareGetter) -> Iterator[Row]:
    """Rank correlations.

    Spearman's correlation of each feature with the score of a task. For all models together, a task's score
    is the mean of the models' scores. Intervals are from a jackknife over the names of tasks, because
    near copies of a task share a name.
    """
    for suite, answers in suites.items():
        for model, lines in group_by_model(answers).items():
            yield from [
                (*suite, model, *row) for row in _correlate_features_with_task_scores(lines, get_share)
            ]


def _correlate_features_with_task_scores(
    answers: Iterable[AnswerTableLine], get_share: _ShareGetter
) -> Iterator[Row]:
    """Yield for each varying feature its name, its correlation with task scores, and the number of tasks."""
    tasks = group_pairs((line.task, line) for line in answers)
    scores = {t: fmean(Rate(*get_share(a)).share or 0 for a in lines) for t, lines in tasks.items()}
    for feature in FEATURES:
        values = {task: getattr(lines[0], feature) for task, lines in tasks.items()}
        numbers = {task: value for task, value in values.items() if value is not None}
        if len(set(numbers.values())) > 1:
            names = [tasks[task][0].name for task in numbers]
            rho = compute_rank_correlation([scores[task] for task in numbers], list(numbers.values()), names)
            yield feature, rho, len(numbers)


@collect_rows_in_table("adjusted", (*SUITE, "feature", "alone", "together", "answers", "names"))
def _make_feature_effects_table(suites: _AnswersBySuite) -> Iterator[Row]:
    """Adjusted effects.

    The table shows log odds of success per standard deviation of a feature among tasks. They are from
    logistic regressions with one intercept per model: of each feature alone, and of all features together.
    The effect in the column `together` holds other features constant. Intervals are from a jackknife over the
    names of tasks, because near copies of a task share a name.
    """
    for suite, answers in suites.items():
        judged = [answer for answer in answers if answer.success is not None]
        yield from [(*suite, *row) for row in fit_feature_effects_on_success(judged)]


def fit_feature_effects_on_success(answers: Sequence[AnswerTableLine]) -> Iterator[Row]:
    """Yield a row for each task feature (`REGRESSION_COLUMNS`) that varies among the counted answers.

    A row has the name of the feature, its effect on success without other features, and its effect together
    with all features. The row also has the number of counted answers and of different task names. Answers
    with an unknown feature, and models that always or never succeed, do not count.
    """
    import numpy as np

    complete = [a for a in answers if all(value(a) is not None for value in REGRESSION_COLUMNS.values())]
    models = _select_models_with_both_outcomes(complete)
    rows = [answer for answer in complete if answer.model_harness_and_effort in models]
    if not rows:
        return
    success = np.array([float(bool(row.success)) for row in rows])
    clusters = [row.name for row in rows]
    dummies = np.array([[float(row.model_harness_and_effort == model) for model in models] for row in rows])
    columns = {
        name: np.array([value(row) or 0.0 for row in rows]) for name, value in REGRESSION_COLUMNS.items()
    }
    spread = {
        name: (values - values.mean()) / values.std() for name, values in columns.items() if np.ptp(values)
    }
    if not spread:
        return
    whole = fit_logistic_regression(np.column_stack([*spread.values(), dummies]), success, clusters)
    for number, (name, values) in enumerate(spread.items()):
        alone = fit_logistic_regression(np.column_stack([values, dummies]), success, clusters)
        yield name, alone[0], whole[number], len(rows), len(set(clusters))


def _select_models_with_both_outcomes(answers: Iterable[AnswerTableLine]) -> list[str]:
    """Return the models that succeed in some tasks and fail in others."""
    outcomes = group_pairs((answer.model_harness_and_effort, bool(answer.success)) for answer in answers)
    return [model for model, results in outcomes.items() if len({*results}) == 2]


@collect_rows_in_table("by_action", (*SUITE, MODEL, "action", "executed", "tasks"))
def _make_actions_table(steps: Sequence[PlanStepTableLine]) -> Iterator[Row]:
    """Executed steps by action.

    The share of tried steps that were executed. A plan ends with its first failing step. A step that was not
    needed (additional step) is skipped, and the plan continues.
    """
    return _compute_success_rates(steps, lambda step: (step.operator,), lambda step: step.outcome == EXECUTED)


@collect_rows_in_table("by_predicate", (*SUITE, MODEL, "predicate", "reached", "tasks"))
def _make_predicates_table(goals: Sequence[TaskGoalTableLine]) -> Iterator[Row]:
    """Reached goals by predicate.

    The share of goals with the predicate that are reached; a goal with two predicates counts in both. A plan
    that was not executed reaches no goal under protocol strict. Under the protocol of the paper's package,
    some suites count goals that hold at the start.
    """
    return _compute_success_rates(
        goals, lambda goal: tuple(goal.predicates.split()), lambda goal: goal.satisfied
    )


def _compute_success_rates(
    lines: Sequence[TidyTableLine], get_names: Callable[..., tuple[str, ...]], is_success: Callable[..., bool]
) -> Iterator[Row]:
    """Yield for each suite, model, and action or predicate the share of rows (such as steps) that succeed."""
    for key, of_run in group_by_run(lines):
        cases = group_pairs(
            (name, make_task_rate_contribution(line, make_rate_contribution_of_answer(is_success(line))))
            for line in of_run
            for name in get_names(line)
        )
        for name, of_name in sorted(cases.items()):
            yield (
                *key,
                name,
                Estimate.from_task_rate_contributions(of_name),
                len({case.task for case in of_name}),
            )


class _ScoreByFeatureOptions(Options):
    """How success is compared with features of tasks.

    Attributes:
        bins: Width of a bin of plan lengths, in steps of annotated plans.
        measure: The score that is compared with features: score, executable or goals.
    """

    bins: int = Field(default=10, ge=1)
    measure: AnswerScoreName = "score"


def _analyze_task_features(records: StudyRecords, options: _ScoreByFeatureOptions) -> Iterator[Analysis]:
    tables = make_task_feature_tables(
        records.make_tidy_tables_of_comparable_runs(), bin_width=options.bins, measure=options.measure
    )
    yield Analysis(tables, _draw_task_feature_figures(tables, options.measure))


def _draw_task_feature_figures(tables: Sequence[Table], measure: AnswerScoreName) -> Figures:
    adjusted, _, curves, by_action, by_predicate = tables
    for suite, rows in group_rows_by_suite(curves).items():
        yield make_file_name_and_titled_suite_figure(
            suite, "curves", draw_success_by_feature(rows, f"{measure}, percent")
        )
    for suite, rows in group_rows_by_suite(adjusted).items():
        yield make_file_name_and_titled_suite_figure(suite, "adjusted", draw_feature_effects(rows))
    for suite, rows in group_rows_by_suite(by_action).items():
        figure = draw_rates_by_name(rows, "action", "executed", "executed of the steps tried")
        yield make_file_name_and_titled_suite_figure(suite, "by_action", figure)
    for suite, rows in group_rows_by_suite(by_predicate).items():
        figure = draw_rates_by_name(rows, "predicate", "reached", "reached of the goals that mention it")
        yield make_file_name_and_titled_suite_figure(suite, "by_predicate", figure)


DRAWN_FEATURES = (
    "annotated_steps",
    "annotated_operators",
    "ground_relation_goals",
    "ground_state_goals",
    "objects",
    "quantified_goals",
)
"""Names of the features that have a panel in the figure. The table has all features."""

_PANELS_PER_ROW = 2
_HEIGHT = 1.9
_EFFECT_ROW = 0.3


def draw_success_by_feature(rows: Sequence[Mapping[str, Cell]], label: str) -> Figure | None:
    """Draw success by feature, one panel per feature; return None if no feature is known.

    The line of the mean of all models has intervals. Each model has a thin line without intervals.
    """
    shown = [name for name in DRAWN_FEATURES if any(row["feature"] == name for row in rows)]
    if not shown:
        return None
    lines = -(-len(shown) // _PANELS_PER_ROW)
    figure = make_figure(COLUMN * _PANELS_PER_ROW, _HEIGHT * lines)
    grid = figure.subplots(lines, _PANELS_PER_ROW, squeeze=False, sharey=True)
    for number, panel in enumerate(grid.flat):
        if number < len(shown):
            _draw_feature(panel, shown[number], [row for row in rows if row["feature"] == shown[number]])
        else:
            panel.set_axis_off()
    for panels in grid:
        panels[0].set_ylabel(label)
    return figure


def _draw_feature(panel: Axes, feature: str, rows: Sequence[Mapping[str, Cell]]) -> None:
    panel.set_ylim(-4, 104)
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    panel.set_title(feature.replace("_", " "), fontsize=8.5)
    bins = sorted({(int(str(row["from"])), int(str(row["to"]))) for row in rows})
    models = group_pairs((row["model"], (int(str(row["from"])), row)) for row in rows)
    first, *others = [dict(of_model) for of_model in models.values()]
    numbers = range(len(bins))
    for of_bin in others:
        cells = [of_bin[low]["score"] if low in of_bin else None for low, _ in bins]
        draw_line(panel, numbers, cells, MUTED, "-", intervals=False, linewidth=0.6, alpha=0.55)
    cells = [first[low]["score"] if low in first else None for low, _ in bins]
    hollow = [number for number, (low, _) in enumerate(bins) if low in first and first[low]["few"]]
    draw_line(panel, numbers, cells, INK, hollow=hollow)
    labels = [
        f"{_format_bin(low, high)}\n{first[low]['tasks'] if low in first else ''}" for low, high in bins
    ]
    panel.set_xticks(range(len(bins)), labels=labels, fontsize=6.5)
    panel.text(-0.02, -0.17, "tasks", transform=panel.transAxes, fontsize=6.5, ha="right", va="top")


def _format_bin(low: int, high: int) -> str:
    return str(low) if low == high else f"{low:,}–{high:,}"


def draw_feature_effects(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """Draw the effect of each feature in log odds, alone (hollow) and with all others (filled).

    The result is None if there are no rows.
    """
    if not rows:
        return None
    figure = make_figure(COLUMN, 1.12 + _EFFECT_ROW * len(rows))
    panel = figure.subplots()
    panel.axvline(0, color=MUTED, linewidth=0.8)
    for number, row in enumerate(rows):
        draw_estimate(panel, number - 0.14, row["alone"], MUTED, "white")
        draw_estimate(panel, number + 0.14, row["together"], INK, INK)
    panel.set_yticks(
        range(len(rows)), labels=[str(row["feature"]).replace("_", " ") for row in rows], fontsize=7
    )
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    meaning = "log odds of success per standard deviation\n○ alone   ● beside the others\n"
    answers, names = (int(str(rows[0][column])) for column in ("answers", "names"))
    panel.set_xlabel(f"{meaning}{answers:,} answers to tasks of {names:,} names", fontsize=7)
    return figure


COFACTORS = Study(
    "cofactors",
    "Success against what tasks are like, and what is left of each feature beside the others.",
    choices=_ScoreByFeatureOptions,
    analyze=_analyze_task_features,
    included_in_all=True,
)
