"""Cofactors of success (paper, section "Correlation with Action Length and Goal Complexity").

The paper draws success against six properties of a task for one model in one suite. Here are the same curves
for any model and suite, by any feature of a task, and what they cannot show: how much is left of each
feature when all are taken together. A long plan is one with many objects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields
from statistics import fmean
from typing import TypeAlias

from eai.abilities.explanation import EXECUTED
from eai.abilities.verdict import Share, of_all
from eai.benchmark.features import Features
from eai.data.grouping import grouped
from eai.results.certainty import Case
from eai.results.lines import (
    MEASURES,
    MODEL,
    SUITE,
    AnswerLine,
    GoalLine,
    Line,
    Measure,
    StepLine,
    SuiteKey,
    by_model,
    by_run,
    by_suite,
    case_of,
)
from eai.results.rate import Rate
from eai.results.table import Estimate, Row, Table, table_of
from eai.results.tidy import Tables
from eai.studies.cofactors.effects import fit_logit, rank_correlation

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


def cofactor_tables(tables: Tables, *, width: int, measure: Measure) -> list[Table]:
    """The tables of the analysis.

    Args:
        tables: the tidy tables.
        width: how many lengths of the annotated plan stand together; 10 are the paper's bins.
        measure: what features are set against.
    """
    suites, share_of = by_suite(tables.answers), MEASURES[measure]
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


@table_of("curves", (*SUITE, MODEL, "feature", "from", "to", "score", "tasks", "few"))
def _curves(suites: _Suites, share_of: _ShareOf, width: int, few: int = FEW) -> Iterator[Row]:
    """Score by feature.

    The score (task success; F1 in goal interpretation) of the tasks whose feature is in a bin, both bounds
    included. Annotated steps are in bins of {width}, the others in bins of the smallest of 1, 2, 5, 10, ...
    that makes no more than eight, or by decades. A bin without tasks is not there; few marks those with fewer
    than {few} tasks. Intervals have the names of tasks as units.
    """
    for suite, answers in suites.items():
        models = by_model(answers)
        for feature in FEATURES:
            values = {value for each in answers if (value := getattr(each, feature)) is not None}
            if len(values) > 1:
                bin_of = bins_of(feature, values, width)
                for model, found in models.items():
                    known = [(value, a) for a in found if (value := getattr(a, feature)) is not None]
                    binned = grouped((bin_of(value), case_of(a, share_of(a))) for value, a in known)
                    yield from [(*suite, model, feature, *row) for row in _curve(binned, few)]


def _curve(binned: Mapping[tuple[int, int], Sequence[Case]], few: int) -> Iterator[Row]:
    for (low, high), cases in sorted(binned.items()):
        tasks = len({case.task for case in cases})
        yield low, high, Estimate.of(cases), tasks, tasks < few


@table_of("correlations", (*SUITE, MODEL, "feature", "rho", "tasks"))
def _correlations(suites: _Suites, share_of: _ShareOf) -> Iterator[Row]:
    """Rank correlations.

    Spearman's correlation of a task's score (its mean over models, where they are together) with each
    feature. Intervals are a jackknife over names.
    """
    for suite, answers in suites.items():
        for model, found in by_model(answers).items():
            yield from [(*suite, model, *row) for row in _correlated(found, share_of)]


def _correlated(answers: Iterable[AnswerLine], share_of: _ShareOf) -> Iterator[Row]:
    """For each feature that varies its name, its correlation with the scores of tasks, and their number."""
    tasks = grouped((each.task, each) for each in answers)
    scores = {t: fmean(Rate(*share_of(a)).share or 0 for a in found) for t, found in tasks.items()}
    for feature in FEATURES:
        values = {task: getattr(found[0], feature) for task, found in tasks.items()}
        known = {task: value for task, value in values.items() if value is not None}
        if len(set(known.values())) > 1:
            names = [tasks[task][0].name for task in known]
            rho = rank_correlation([scores[task] for task in known], list(known.values()), names)
            yield feature, rho, len(known)


@table_of("adjusted", (*SUITE, "feature", "alone", "together", "answers", "names"))
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
    outcomes = grouped((answer.agent, bool(answer.success)) for answer in answers)
    return [model for model, found in outcomes.items() if len({*found}) == 2]


@table_of("by_action", (*SUITE, MODEL, "action", "executed", "tasks"))
def _by_action(steps: Sequence[StepLine]) -> Iterator[Row]:
    """Executed steps by action.

    Steps that were executed of those that were tried. A plan ends with its first failing step; a step that
    was not needed is not executed, and the plan goes on.
    """
    return _rates(steps, lambda step: (step.operator,), lambda step: step.outcome == EXECUTED)


@table_of("by_predicate", (*SUITE, MODEL, "predicate", "reached", "tasks"))
def _by_predicate(goals: Sequence[GoalLine]) -> Iterator[Row]:
    """Reached goals by predicate.

    Goals that are reached of those that mention the predicate; a goal with two predicates counts in both. An
    answer that was not executed reaches what its protocol says: nothing under strict, what holds at the start
    in some suites of the reference.
    """
    return _rates(goals, lambda goal: tuple(goal.predicates.split()), lambda goal: goal.satisfied)


def _rates(
    lines: Sequence[Line], names_of: Callable[..., tuple[str, ...]], counts: Callable[..., bool]
) -> Iterator[Row]:
    """For each suite, model and name the share of lines that count."""
    for key, found in by_run(lines):
        cases = grouped(
            (name, case_of(line, of_all(counts(line)))) for line in found for name in names_of(line)
        )
        for name, of_name in sorted(cases.items()):
            yield (*key, name, Estimate.of(of_name), len({case.task for case in of_name}))
