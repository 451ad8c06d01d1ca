"""Outcomes of a run and where they arose: stages, and success by features of a task or an answer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from eai.abilities.declaration import AnswerOutcome, declaration_of
from eai.abilities.explanation import EXECUTED, GoalReport, StepReport
from eai.abilities.protocol import Ability
from eai.abilities.record import Record
from eai.abilities.verdict import NONE, PlanVerdict, Share, of_all
from eai.results.certainty import Case
from eai.results.rate import Rate, rate_of
from eai.results.repeats import repeated_metric
from eai.results.summary import name_of

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.declaration import OperatorVerdict

_NO_ANSWER = frozenset({AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED})
"""Where there is no answer to break down."""


_LOST = {
    "readable": AnswerOutcome.PARSING,
    "known": AnswerOutcome.HALLUCINATION,
    "well_formed": AnswerOutcome.ARGUMENT_NUMBER,
}
"""The outcomes of answers that do not reach a stage."""


@dataclass(frozen=True, slots=True)
class Breakdown:
    """One run's answers by what they came to.

    Attributes:
        outcomes: how many answers came to what.
        flow: how many scored answers came how far, by stage: answers, readable, known (without unknown
            names), well_formed (each action has as many arguments as it takes), executed, reached; None for
            abilities without plans.
        by_goals: number of goals of the task -> success of each answer to such a task; where a record stands
            for several answers, their mean.
        by_length: number of steps of the data set's own plan -> the same. How many steps of an answer were
            tried is an outcome: a plan that fails early would count as a short one.
        by_action: operator -> share of its steps that were executed, of all that were tried, additional ones
            too (they are not executed); of transition modeling, F1.
        by_predicate: predicate -> share of goals that mention it that are met; of transition modeling, F1.
    """

    outcomes: Mapping[AnswerOutcome, int]
    flow: Mapping[str, int] | None
    by_goals: Mapping[int, Sequence[Case]]
    by_length: Mapping[int, Sequence[Case]]
    by_action: Mapping[str, Rate]
    by_predicate: Mapping[str, Rate]


def outcome(record: Record) -> AnswerOutcome:
    """The outcome of an answer, or that there is none."""
    if record.verdict.excluded is not None:
        return AnswerOutcome.EXCLUDED
    if record.unanswered is not None:
        return AnswerOutcome.NOT_ANSWERED
    return declaration_of(record.ability).outcome(record.verdict)


def break_down(records: Iterable[Record], ability: Ability) -> Breakdown:
    """The breakdown of a run's records, all of one ability.

    Where there is no answer, or it is excluded, that is an outcome and nothing else. Records that do not say
    what their tasks are like are in none of the breakdowns by task.
    """
    declared = declaration_of(ability)
    metric = None if declared.of_epochs is None else repeated_metric(ability)
    outcomes: Counter[AnswerOutcome] = Counter()
    by_goals: dict[int, list[Case]] = {}
    by_length: dict[int, list[Case]] = {}
    by_action: dict[str, list[Share]] = {}
    by_predicate: dict[str, list[Share]] = {}
    for record in records:
        came_to = outcome(record)
        outcomes[came_to] += 1
        if came_to in _NO_ANSWER:
            continue
        success = Case(record.task_id, name_of(record), _success(record, came_to, metric))
        if record.task is not None:
            by_goals.setdefault(record.task.goals, []).append(success)
            if declared.has_plans and record.task.annotated_steps is not None:
                by_length.setdefault(record.task.annotated_steps, []).append(success)
        if declared.asked.of_operators:
            _break_down_operators(cast("OperatorVerdict", record.verdict), by_action, by_predicate)
        for report, reached in goals_of(record):
            for name in report.predicates:
                by_predicate.setdefault(name, []).append(of_all(reached))
        for _, step in steps_of(record) if declared.has_plans else ():
            by_action.setdefault(step.call.name, []).append(of_all(step.outcome == EXECUTED))
    return Breakdown(
        {kind: outcomes[kind] for kind in AnswerOutcome if outcomes[kind]},
        _flow(outcomes) if declared.has_plans else None,
        dict(sorted(by_goals.items())),
        dict(sorted(by_length.items())),
        _rates(by_action),
        _rates(by_predicate),
    )


def _success(record: Record, came_to: AnswerOutcome, metric: str | None) -> Share:
    """Whether an answer is right; by a metric that answers add their means to, if there is one."""
    if metric is None:
        return Share(came_to is AnswerOutcome.SUCCESS, 1)
    return declaration_of(record.ability).contributions(record.verdict)[metric]


def _flow(outcomes: Mapping[AnswerOutcome, int]) -> dict[str, int]:
    flow = {"answers": sum(count for kind, count in outcomes.items() if kind not in _NO_ANSWER)}
    left = flow["answers"]
    for stage, lost in _LOST.items():
        flow[stage] = left = left - outcomes.get(lost, 0)
    reached = outcomes.get(AnswerOutcome.SUCCESS, 0)
    return {**flow, "executed": reached + outcomes.get(AnswerOutcome.GOAL_MISSED, 0), "reached": reached}


def goals_of(record: Record) -> Iterator[tuple[GoalReport, bool]]:
    """The goals that a record tells of, and whether they count as reached."""
    reports = () if record.explanation is None else record.explanation.goals
    counted = record.verdict.goals_satisfied if isinstance(record.verdict, PlanVerdict) else ()
    reached = counted if len(counted) == len(reports) else [report.satisfied for report in reports]
    yield from zip(reports, reached, strict=True)


def steps_of(record: Record) -> Iterator[tuple[int, StepReport]]:
    """The steps that a record tells of at which an action was tried, with their numbers from 0."""
    steps = () if record.explanation is None else record.explanation.steps
    yield from ((number, step) for number, step in enumerate(steps) if record.verdict.is_action(number))


def _break_down_operators(
    verdict: OperatorVerdict, by_action: dict[str, list[Share]], by_predicate: dict[str, list[Share]]
) -> None:
    """Count the clauses of operators by operator, and by predicate once for each that stands in them."""
    for operator in verdict.operators:
        for side in (operator.precondition, operator.effect):
            wrong = (*side.additional, *side.missing)
            found = [*((part, _TWICE) for part in side.matched), *((part, NONE) for part in wrong)]
            for part, share in found:
                by_action.setdefault(operator.name, []).append(share)
                for predicate in verdict.clauses[part].predicates:
                    by_predicate.setdefault(predicate, []).append(share)


_TWICE = Share(2, 2)
"""The contribution of a match to F1, which is 2 TP / (2 TP + FP + FN)."""


def _rates(shares: Mapping[str, Sequence[Share]]) -> dict[str, Rate]:
    return {name: rate_of(found) for name, found in sorted(shares.items())}
