"""What a run came to, and where: outcomes, stages, and success by what a task or an answer is like."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from eai.abilities.declaration import AnswerOutcome
from eai.abilities.declarations import DECLARATIONS
from eai.abilities.explanation import Explanation
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.verdict import OperatorVerdict, PlanVerdict, Verdict
from eai.metrics.rate import Rate
from eai.world.fault import FaultKind

VOCABULARY_ERRORS = frozenset({AnswerOutcome.HALLUCINATION, AnswerOutcome.ARGUMENT_NUMBER})
"""Errors in names, found before anything is executed."""

_NO_ANSWER = frozenset({AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED})
"""Where there is no answer to break down."""


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

    outcomes: Mapping[AnswerOutcome, int]
    flow: Flow | None
    by_goals: Mapping[int, Rate]
    by_length: Mapping[int, Rate]
    by_action: Mapping[str, Rate]
    by_predicate: Mapping[str, Rate]


def outcome(record: Record) -> AnswerOutcome:
    """What an answer came to, or that there is none."""
    if record.verdict.excluded is not None:
        return AnswerOutcome.EXCLUDED
    if record.unanswered is not None:
        return AnswerOutcome.NOT_ANSWERED
    return DECLARATIONS[record.ability].outcome(record.verdict)


def break_down(records: Iterable[Record], ability: Ability) -> Breakdown:
    """The breakdown of a run's records, all of one ability.

    Where there is no answer, or it is excluded, that is an outcome and nothing else.
    """
    has_plans = DECLARATIONS[ability].has_plans
    outcomes: Counter[AnswerOutcome] = Counter()
    by_goals: dict[int, Rate] = {}
    by_length: dict[int, Rate] = {}
    by_action: dict[str, Rate] = {}
    by_predicate: dict[str, Rate] = {}
    for record in records:
        verdict = record.verdict
        came_to = outcome(record)
        outcomes[came_to] += 1
        if came_to in _NO_ANSWER:
            continue
        success = Rate(came_to is AnswerOutcome.SUCCESS, 1)
        explanation = record.explanation or Explanation()
        number = _number_of_goals(verdict, explanation)
        if number:
            _put(by_goals, number, success)
        if has_plans and explanation.steps:
            _put(by_length, len(explanation.steps), success)
        if isinstance(verdict, OperatorVerdict):
            _break_down_operators(verdict, by_action, by_predicate)
        _break_down_goals(explanation, by_predicate)
        if has_plans:
            _break_down_steps(explanation, by_action)
    return Breakdown(
        {kind: outcomes[kind] for kind in AnswerOutcome if outcomes[kind]},
        _flow(outcomes) if has_plans else None,
        _ordered(by_goals),
        _ordered(by_length),
        _ordered(by_action),
        _ordered(by_predicate),
    )


def _flow(outcomes: Mapping[AnswerOutcome, int]) -> Flow:
    answers = sum(count for kind, count in outcomes.items() if kind not in _NO_ANSWER)
    readable = answers - outcomes.get(AnswerOutcome.PARSING, 0)
    known = readable - sum(outcomes.get(kind, 0) for kind in VOCABULARY_ERRORS)
    reached = outcomes.get(AnswerOutcome.SUCCESS, 0)
    return Flow(answers, readable, known, reached + outcomes.get(AnswerOutcome.GOAL_MISSED, 0), reached)


def _number_of_goals(verdict: Verdict, explanation: Explanation) -> int:
    if isinstance(verdict, PlanVerdict) and verdict.goals is not None:
        return round(sum(tally.total for tally in verdict.goals))
    return len(explanation.goals)


def _break_down_goals(explanation: Explanation, by_predicate: dict[str, Rate]) -> None:
    for goal in explanation.goals:
        first = _NAME.search(goal.goal)
        _put(by_predicate, first[1] if first else goal.goal, Rate(goal.satisfied, 1))


def _break_down_steps(explanation: Explanation, by_action: dict[str, Rate]) -> None:
    for step in explanation.steps:
        tried = Rate(step.outcome in ("executed", FaultKind.ADDITIONAL_STEP.value), 1)
        _put(by_action, step.action.partition("(")[0], tried)


def _break_down_operators(
    verdict: OperatorVerdict, by_action: dict[str, Rate], by_predicate: dict[str, Rate]
) -> None:
    """Count the predicates of written operators, by operator and by predicate."""
    for operator in verdict.operators:
        for side in (operator.precondition, operator.effect):
            wrong = (*side.additional, *side.missing)
            found = [*((name, Rate(2, 2)) for name in side.matched), *((name, Rate(0, 1)) for name in wrong)]
            for predicate, rate in found:  # F1 is 2 TP / (2 TP + FP + FN)
                _put(by_action, operator.name, rate)
                _put(by_predicate, predicate, rate)


_NAME = re.compile(r"(\w+)\(")
"""The first predicate of a goal; an action goal has none and stands for itself."""

_Key = TypeVar("_Key", int, str)


def _put(table: dict[_Key, Rate], key: _Key, rate: Rate) -> None:
    before = table.get(key, Rate(0, 0))
    table[key] = Rate(before.numerator + rate.numerator, before.denominator + rate.denominator)


def _ordered(table: Mapping[_Key, Rate]) -> dict[_Key, Rate]:
    return dict(sorted(table.items()))
