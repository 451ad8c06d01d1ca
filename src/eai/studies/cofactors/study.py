"""Cofactors: what success depends on (paper, "Correlation with Action Length and Goal Complexity").

The paper draws success against six properties of a task for one model in one suite. Here are the same curves
for any model and suite, by any feature of a task, and what they cannot show: how much is left of each
feature when all are taken together. A long plan is one with many objects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from statistics import fmean
from typing import TYPE_CHECKING, TypeAlias

from pydantic import Field

from eai.abilities.explanation import EXECUTED
from eai.abilities.verdict import share_of_one
from eai.base.grouping import group_pairs
from eai.benchmarks.features import Features
from eai.results.certainty import Case
from eai.results.lines import (
    MEASURES,
    MODEL,
    SUITE,
    AnswerLine,
    AnswerMeasure,
    GoalLine,
    StepLine,
    SuiteKey,
    TidyLine,
    group_by_model,
    group_by_run,
    group_by_suite,
    make_case,
)
from eai.results.plots import (
    COLUMN,
    INK,
    MUTED,
    RULE,
    draw_estimate,
    draw_line,
    draw_names,
    make_figure,
    rows_of,
)
from eai.results.rate import Rate
from eai.results.table import Cell, Estimate, Row, Table, make_table
from eai.results.tidy import TidyTables
from eai.studies.cofactors.effects import fit_logit, rank_correlation
from eai.studies.records import Records
from eai.studies.study import Analysis, Figures, Study, of_suite
from eai.tasks.options import Options
from eai.tasks.share import Share

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


STEPS = "annotated_steps"

FEATURES = tuple([each.name for each in fields(Features) if each.name != "ground_action_goals"])
"""The features of a task that a score is set against; ground goals that are actions are as many as those."""

FEW = 5
"""A bin with fewer tasks says little."""

_Suites: TypeAlias = Mapping[SuiteKey, Sequence[AnswerLine]]
_ShareOf: TypeAlias = Callable[[AnswerLine], Share]

_MOST_BINS = 8
_NICE = (1, 2, 5)


def _log(number: int | None) -> float | None:
    return math.log(number) if number else None


ADJUSTED: Mapping[str, Callable[[AnswerLine], float | None]] = {
    f"log {STEPS}": lambda answer: _log(answer.annotated_steps),
    "ground_relation_goals": lambda answer: answer.ground_relation_goals,
    "ground_state_goals": lambda answer: answer.ground_state_goals,
    "ground_action_goals": lambda answer: answer.ground_action_goals,
    "log objects": lambda answer: _log(answer.objects),
    "any tool_steps": lambda answer: None if answer.tool_steps is None else float(answer.tool_steps > 0),
    "quantified_goals": lambda answer: answer.quantified_goals,
}
"""The columns of the adjusted regression, and how a feature enters each."""


def cofactor_tables(tables: TidyTables, *, width: int, measure: AnswerMeasure) -> list[Table]:
    """The tables of the analysis.

    Args:
        tables: the tidy tables.
        width: how many lengths of the annotated plan stand together; 10 are the paper's bins.
        measure: what features are set against.
    """
    suites, share_of = group_by_suite(tables.answers), MEASURES[measure]
    judged = {
        suite: [answer for answer in answers if share_of(answer).denominator]
        for suite, answers in suites.items()
    }
    return [
        _adjusted(suites),
        _correlations(judged, share_of),
        _curves(judged, share_of, width),
        _by_action(tables.steps),
        _by_predicate(tables.goals),
    ]


def bins_of(feature: str, values: Iterable[int], width: int) -> Callable[[int], tuple[int, int]]:
    """The bins of a feature, each with its lowest and highest value.

    Steps stand together by ``width``; other features by the smallest of 1, 2, 5, 10, ... that makes no more
    than eight bins, or by decades (0, 1, 2-9, 10-99, ...) where they go above a thousand.
    """
    highest = max(values, default=0)
    if feature != STEPS:
        if highest > 1000:
            return _decade
        sizes = (nice * 10**power for power in range(4) for nice in _NICE)
        width = next(size for size in sizes if highest // size < _MOST_BINS)
    return lambda value: (value // width * width, value // width * width + width - 1)


def _decade(value: int) -> tuple[int, int]:
    if value < 2:
        return value, value
    power = 10 ** int(math.log10(value) + 1e-9)
    return (2, 9) if power == 1 else (power, 10 * power - 1)


@make_table("curves", (*SUITE, MODEL, "feature", "from", "to", "score", "tasks", "few"))
def _curves(suites: _Suites, share_of: _ShareOf, width: int, few: int = FEW) -> Iterator[Row]:
    """Score by feature.

    The score (task success; F1 in goal interpretation) of the tasks whose feature is in a bin, both bounds
    included. Annotated steps are in bins of {width}, the others in bins of the smallest of 1, 2, 5, 10, ...
    that makes no more than eight, or by decades. A bin without tasks is not there; few marks those with fewer
    than {few} tasks. Intervals have the names of tasks as units.
    """
    for suite, answers in suites.items():
        models = group_by_model(answers)
        for feature in FEATURES:
            values = {value for each in answers if (value := getattr(each, feature)) is not None}
            if len(values) > 1:
                bin_of = bins_of(feature, values, width)
                for model, found in models.items():
                    known = [(value, a) for a in found if (value := getattr(a, feature)) is not None]
                    binned = group_pairs((bin_of(value), make_case(a, share_of(a))) for value, a in known)
                    yield from [(*suite, model, feature, *row) for row in _curve(binned, few)]


def _curve(binned: Mapping[tuple[int, int], Sequence[Case]], few: int) -> Iterator[Row]:
    for (low, high), cases in sorted(binned.items()):
        tasks = len({case.task for case in cases})
        yield low, high, Estimate.from_cases(cases), tasks, tasks < few


@make_table("correlations", (*SUITE, MODEL, "feature", "rho", "tasks"))
def _correlations(suites: _Suites, share_of: _ShareOf) -> Iterator[Row]:
    """Rank correlations.

    Spearman's correlation of a task's score (its mean over models, where they are together) with each
    feature. Intervals are a jackknife over names.
    """
    for suite, answers in suites.items():
        for model, found in group_by_model(answers).items():
            yield from [(*suite, model, *row) for row in _correlated(found, share_of)]


def _correlated(answers: Iterable[AnswerLine], share_of: _ShareOf) -> Iterator[Row]:
    """For each feature that varies its name, its correlation with the scores of tasks, and their number."""
    tasks = group_pairs((each.task, each) for each in answers)
    scores = {t: fmean(Rate(*share_of(a)).share or 0 for a in found) for t, found in tasks.items()}
    for feature in FEATURES:
        values = {task: getattr(found[0], feature) for task, found in tasks.items()}
        known = {task: value for task, value in values.items() if value is not None}
        if len(set(known.values())) > 1:
            names = [tasks[task][0].name for task in known]
            rho = rank_correlation([scores[task] for task in known], list(known.values()), names)
            yield feature, rho, len(known)


@make_table("adjusted", (*SUITE, "feature", "alone", "together", "answers", "names"))
def _adjusted(suites: _Suites) -> Iterator[Row]:
    """Adjusted effects.

    Log odds of success per standard deviation of a feature among tasks, in a logistic regression with an
    effect of each model: each feature alone, and all together. What is left of a feature when all are
    together is not owed to the others. Intervals are a jackknife over names.
    """
    for suite, answers in suites.items():
        judged = [answer for answer in answers if answer.success is not None]
        yield from [(*suite, *row) for row in adjusted(judged)]


def adjusted(answers: Sequence[AnswerLine]) -> Iterator[Row]:
    """For each varying column of `ADJUSTED`: name, effect alone and together, answers and names."""
    import numpy as np

    known = [a for a in answers if all(value(a) is not None for value in ADJUSTED.values())]
    models = _undecided(known)
    rows = [answer for answer in known if answer.agent in models]
    if not rows:
        return
    success = np.array([float(bool(row.success)) for row in rows])
    clusters = [row.name for row in rows]
    dummies = np.array([[float(row.agent == model) for model in models] for row in rows])
    columns = {name: np.array([value(row) or 0.0 for row in rows]) for name, value in ADJUSTED.items()}
    spread = {
        name: (values - values.mean()) / values.std() for name, values in columns.items() if values.std()
    }
    if not spread:
        return
    whole = fit_logit(np.column_stack([*spread.values(), dummies]), success, clusters)
    for number, (name, values) in enumerate(spread.items()):
        alone = fit_logit(np.column_stack([values, dummies]), success, clusters)
        yield name, alone[0], whole[number], len(rows), len(set(clusters))


def _undecided(answers: Iterable[AnswerLine]) -> list[str]:
    """The models that succeed in some tasks and fail in others; the rest says nothing about tasks."""
    outcomes = group_pairs((answer.agent, bool(answer.success)) for answer in answers)
    return [model for model, found in outcomes.items() if len({*found}) == 2]


@make_table("by_action", (*SUITE, MODEL, "action", "executed", "tasks"))
def _by_action(steps: Sequence[StepLine]) -> Iterator[Row]:
    """Executed steps by action.

    Steps that were executed of those that were tried. A plan ends with its first failing step; a step that
    was not needed is not executed, and the plan goes on.
    """
    return _rates(steps, lambda step: (step.operator,), lambda step: step.outcome == EXECUTED)


@make_table("by_predicate", (*SUITE, MODEL, "predicate", "reached", "tasks"))
def _by_predicate(goals: Sequence[GoalLine]) -> Iterator[Row]:
    """Reached goals by predicate.

    Goals that are reached of those that mention the predicate; a goal with two predicates counts in both. An
    answer that was not executed reaches what its protocol says: nothing under strict, what holds at the start
    in some suites of the reference.
    """
    return _rates(goals, lambda goal: tuple(goal.predicates.split()), lambda goal: goal.satisfied)


def _rates(
    lines: Sequence[TidyLine], names_of: Callable[..., tuple[str, ...]], counts: Callable[..., bool]
) -> Iterator[Row]:
    """For each suite, model and name the share of lines that count."""
    for key, found in group_by_run(lines):
        cases = group_pairs(
            (name, make_case(line, share_of_one(counts(line)))) for line in found for name in names_of(line)
        )
        for name, of_name in sorted(cases.items()):
            yield (*key, name, Estimate.from_cases(of_name), len({case.task for case in of_name}))


class _Choices(Options):
    """How success is set against features of tasks.

    Attributes:
        bins: How many lengths of annotated plans stand together.
        measure: What features of tasks are set against: score, executable or goals.
    """

    bins: int = Field(default=10, ge=1)
    measure: AnswerMeasure = "score"


def _analyze(records: Records, chosen: _Choices) -> Iterator[Analysis]:
    found = cofactor_tables(records.tables(), width=chosen.bins, measure=chosen.measure)
    yield Analysis(found, _figures(found, chosen.measure))


def _figures(found: Sequence[Table], measure: AnswerMeasure) -> Figures:
    adjusted, _, curves, by_action, by_predicate = found
    for suite, rows in rows_of(curves).items():
        yield of_suite(suite, "curves", draw_curves(rows, f"{measure}, percent"))
    for suite, rows in rows_of(adjusted).items():
        yield of_suite(suite, "adjusted", draw_effects(rows))
    for suite, rows in rows_of(by_action).items():
        figure = draw_names(rows, "action", "executed", "executed of the steps tried")
        yield of_suite(suite, "by_action", figure)
    for suite, rows in rows_of(by_predicate).items():
        figure = draw_names(rows, "predicate", "reached", "reached of the goals that mention it")
        yield of_suite(suite, "by_predicate", figure)


SHOWN = (
    "annotated_steps",
    "annotated_operators",
    "ground_relation_goals",
    "ground_state_goals",
    "objects",
    "quantified_goals",
)
"""The features that are drawn; the table has them all."""

_PER_ROW = 2
_HEIGHT = 1.9
_EFFECT_ROW = 0.3


def draw_curves(rows: Sequence[Mapping[str, Cell]], label: str) -> Figure | None:
    """Success by feature, a panel a feature: all models together with intervals, each of them as a thin line.

    None if no feature is known.
    """
    shown = [name for name in SHOWN if any(row["feature"] == name for row in rows)]
    if not shown:
        return None
    lines = -(-len(shown) // _PER_ROW)
    figure = make_figure(COLUMN * _PER_ROW, _HEIGHT * lines)
    grid = figure.subplots(lines, _PER_ROW, squeeze=False, sharey=True)
    for place, panel in enumerate(grid.flat):
        if place < len(shown):
            _draw_feature(panel, shown[place], [row for row in rows if row["feature"] == shown[place]])
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
    places = range(len(bins))
    for of_bin in others:
        cells = [of_bin[low]["score"] if low in of_bin else None for low, _ in bins]
        draw_line(panel, places, cells, MUTED, "-", intervals=False, linewidth=0.6, alpha=0.55)
    cells = [first[low]["score"] if low in first else None for low, _ in bins]
    hollow = [place for place, (low, _) in enumerate(bins) if low in first and first[low]["few"]]
    draw_line(panel, places, cells, INK, hollow=hollow)
    labels = [f"{_bin(low, high)}\n{first[low]['tasks'] if low in first else ''}" for low, high in bins]
    panel.set_xticks(range(len(bins)), labels=labels, fontsize=6.5)
    panel.text(-0.02, -0.17, "tasks", transform=panel.transAxes, fontsize=6.5, ha="right", va="top")


def _bin(low: int, high: int) -> str:
    return str(low) if low == high else f"{low:,}–{high:,}"


def draw_effects(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """The log odds of each feature, alone (hollow) and beside the others (filled); None if there are none."""
    if not rows:
        return None
    figure = make_figure(COLUMN, 1.12 + _EFFECT_ROW * len(rows))
    panel = figure.subplots()
    panel.axvline(0, color=MUTED, linewidth=0.8)
    for place, row in enumerate(rows):
        draw_estimate(panel, place - 0.14, row["alone"], MUTED, "white")
        draw_estimate(panel, place + 0.14, row["together"], INK, INK)
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
    choices=_Choices,
    analyze=_analyze,
    together=True,
)
