"""What a run came to, and where: outcomes, stages, and success by what a task or an answer is like."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeVar

from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.verdict import Confusion, Verdict, fields_of
from eai.metrics.explained import explanation_of
from eai.metrics.rate import Rate, add
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind


class Outcome(str, Enum):
    """What one answer came to: the first of these that fits, in this order but for the errors."""

    EXCLUDED = "excluded"
    SUCCESS = "success"
    PARTLY_RIGHT = "partly_right"
    """Goals or operators of which some are right."""
    GOAL_MISSED = "goal_missed"
    """The plan ran, or the goals or operators could be read, but nothing came of it."""
    PARSING = FaultKind.PARSING.value
    HALLUCINATION = FaultKind.HALLUCINATION.value
    ARGUMENT_NUMBER = FaultKind.ARGUMENT_NUMBER.value
    AFFORDANCE = FaultKind.AFFORDANCE.value
    MISSING_STEP = FaultKind.MISSING_STEP.value
    WRONG_ORDER = FaultKind.WRONG_ORDER.value
    ADDITIONAL_STEP = FaultKind.ADDITIONAL_STEP.value
    UNCATEGORISED = FaultKind.UNCATEGORISED.value


VOCABULARY_ERRORS = frozenset({Outcome.HALLUCINATION, Outcome.ARGUMENT_NUMBER})
"""Errors in names, found before anything is executed."""

PLANS = frozenset({Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION})
"""The abilities whose answers are executed."""


class Flow(NamedTuple):
    """How many scored answers came how far."""

    answers: int
    readable: int
    known: int
    executed: int
    reached: int


@dataclass(frozen=True, slots=True)
class Breakdown:
    """One run's answers by what they came to.

    Attributes:
        outcomes: how many answers came to what.
        flow: how far plans came; None for abilities without plans.
        by_goals: number of goals of the task -> success.
        by_length: number of steps of the plan that were tried -> success; needs explanations.
        by_action: operator -> share of its steps that were executed; of transition modeling, F1.
        by_predicate: predicate -> share of goals with it that are met; of transition modeling, F1.
    """

    outcomes: Mapping[Outcome, int]
    flow: Flow | None
    by_goals: Mapping[int, Rate]
    by_length: Mapping[int, Rate]
    by_action: Mapping[str, Rate]
    by_predicate: Mapping[str, Rate]


def outcome(verdict: Verdict, ability: Ability) -> Outcome:
    """What an answer came to."""
    if verdict.excluded is not None:
        return Outcome.EXCLUDED
    if verdict.success:
        return Outcome.SUCCESS
    if verdict.error is not None:
        return Outcome(verdict.error.kind.value)
    if ability in PLANS:
        return Outcome.GOAL_MISSED
    whole = add(_confusions(verdict))
    right = not whole.false_positives and whole.false_negatives <= 0
    if right and verdict.planner in (None, PlannerOutcome.NOT_RUN):
        return Outcome.SUCCESS
    return Outcome.PARTLY_RIGHT if whole.true_positives else Outcome.GOAL_MISSED


def break_down(records: Iterable[Record], ability: Ability) -> Breakdown:
    """The breakdown of a run's records, all of one ability; excluded ones only count as outcomes."""
    outcomes: Counter[Outcome] = Counter()
    by_goals: dict[int, Rate] = {}
    by_length: dict[int, Rate] = {}
    by_action: dict[str, Rate] = {}
    by_predicate: dict[str, Rate] = {}
    for record in records:
        verdict = record.verdict
        came_to = outcome(verdict, ability)
        outcomes[came_to] += 1
        if came_to is Outcome.EXCLUDED:
            continue
        success = Rate(came_to is Outcome.SUCCESS, 1)
        explanation = explanation_of(verdict)
        number = _number_of_goals(verdict, explanation)
        if number:
            _put(by_goals, number, success)
        if ability in PLANS and explanation.steps:
            _put(by_length, len(explanation.steps), success)
        _break_down_operators(verdict, by_action, by_predicate)
        _break_down_explanation(explanation, ability, by_action, by_predicate)
    return Breakdown(
        {kind: outcomes[kind] for kind in Outcome if outcomes[kind]},
        _flow(outcomes) if ability in PLANS else None,
        _ordered(by_goals),
        _ordered(by_length),
        _ordered(by_action),
        _ordered(by_predicate),
    )


def _flow(outcomes: Mapping[Outcome, int]) -> Flow:
    answers = sum(count for kind, count in outcomes.items() if kind is not Outcome.EXCLUDED)
    readable = answers - outcomes.get(Outcome.PARSING, 0)
    known = readable - sum(outcomes.get(kind, 0) for kind in VOCABULARY_ERRORS)
    reached = outcomes.get(Outcome.SUCCESS, 0)
    return Flow(answers, readable, known, reached + outcomes.get(Outcome.GOAL_MISSED, 0), reached)


def _number_of_goals(verdict: Verdict, explanation: Explanation) -> int:
    if verdict.goals is not None:
        return round(sum(tally.total for tally in verdict.goals))
    return len(explanation.goals)


def _break_down_explanation(
    explanation: Explanation, ability: Ability, by_action: dict[str, Rate], by_predicate: dict[str, Rate]
) -> None:
    for goal in explanation.goals:
        first = _NAME.search(goal.goal)
        _put(by_predicate, first[1] if first else goal.goal, Rate(goal.satisfied, 1))
    if ability in PLANS:
        for step in explanation.steps:
            tried = Rate(step.outcome in ("executed", FaultKind.ADDITIONAL_STEP.value), 1)
            _put(by_action, step.action.partition("(")[0], tried)


def _break_down_operators(
    verdict: Verdict, by_action: dict[str, Rate], by_predicate: dict[str, Rate]
) -> None:
    """Count the predicates of written operators, by operator and by predicate."""
    for operator in operators_of(verdict):
        name = str(operator.get("name"))
        for found, predicates in enumerate(_predicates(operator)):  # F1 is 2 TP / (2 TP + FP + FN)
            for predicate in predicates:
                rate = Rate(2, 2) if found == _MATCHED else Rate(0, 1)
                _put(by_action, name, rate)
                _put(by_predicate, predicate, rate)


def operators_of(verdict: Verdict) -> list[Mapping[str, object]]:
    """The reports on written operators, if a verdict has any."""
    found = fields_of(verdict).get("operators")
    return [item for item in found if isinstance(item, Mapping)] if isinstance(found, list) else []


def _predicates(operator: Mapping[str, object]) -> Iterator[list[str]]:
    """Matched, additional and missing predicates of an operator, both sides together."""
    sides = [side for key in ("precondition", "effect") if isinstance(side := operator.get(key), Mapping)]
    for part in ("matched", "additional", "missing"):
        yield [str(name) for side in sides for name in side.get(part, ())]


def _confusions(verdict: Verdict) -> Iterator[Confusion]:
    for value in (verdict.counts or {}).values():
        if isinstance(value, Confusion):
            yield value
        else:
            yield from value.values()


_MATCHED = 0
_NAME = re.compile(r"(\w+)\(")
"""The first predicate of a goal; an action goal has none and stands for itself."""

_Key = TypeVar("_Key", int, str)


def _put(table: dict[_Key, Rate], key: _Key, rate: Rate) -> None:
    before = table.get(key, Rate(0, 0))
    table[key] = Rate(before.numerator + rate.numerator, before.denominator + rate.denominator)


def _ordered(table: Mapping[_Key, Rate]) -> dict[_Key, Rate]:
    return dict(sorted(table.items()))
