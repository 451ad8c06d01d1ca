"""The metrics of a run, as its ability declares them, and what its answers came to.

Metrics are also known by the number of attempts: what a run of an experiment would have come to, had it ended
earlier. The average performance of a model in a domain is as the paper has it. Answers are broken down by
where they failed, and success by features of a task or an answer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias, cast

from eai.abilities.attempt_options import AttemptOptions
from eai.abilities.declaration import AnswerOutcome, declaration_of, load_paper_abilities
from eai.abilities.explanation import EXECUTED, GoalReport, StepReport
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.verdict import EMPTY_SHARE as NO_SHARE
from eai.abilities.verdict import ZERO_SHARE, PlanVerdict, Shares, Verdict, share_of_one
from eai.base.grouping import group_pairs
from eai.results.certainty import Case
from eai.results.rate import NOTHING, Rate, rate_of, total
from eai.results.record import Record
from eai.results.repeats import find_success_metric
from eai.results.table import Estimate
from eai.tasks.share import Share

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.verdict import OperatorVerdict


def summarise(verdicts: Sequence[Verdict], ability: Ability) -> dict[str, Rate]:
    """All metrics of the paper's tables for an ability, by name, over the verdicts that are not excluded.

    Metrics without any verdict are there all the same, as nothing of nothing.
    """
    declared = declaration_of(ability)
    nothing = dict.fromkeys(declared.contributions(declared.verdict()), NOTHING)
    return {**nothing, **total(contributions(verdicts, ability))}


def contributions(verdicts: Sequence[Verdict], ability: Ability) -> Iterator[Shares]:
    """The shares that each verdict of a run that is not excluded contributes to each metric, in order.

    They come one after the other: of a long run all at once are a great many small objects.
    """
    declared = declaration_of(ability)
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    void = dict.fromkeys(
        (metric for verdict in scored for metric in declared.missing_metrics(verdict)), NO_SHARE
    )
    shares = map(declared.contributions, scored)
    return ({**share, **void} for share in shares) if void else shares


def shares_by_task(records: Sequence[Record]) -> dict[str, Shares]:
    """The shares that the records of a run contribute, by task; those of excluded ones are not there."""
    return {record.task_id: shares for record, shares in _contributed(records, records[0].ability)}


def cases_of(records: Sequence[Record], ability: Ability) -> dict[str, list[Case]]:
    """The cases that the records of a run add to each metric, in order; excluded ones add nothing."""
    return group_pairs(
        (metric, Case(task, name, share))
        for record, shares in _contributed(records, ability)
        for task, name in [(record.task_id, name_of(record))]
        for metric, share in shares.items()
    )


def _contributed(records: Sequence[Record], ability: Ability) -> Iterator[tuple[Record, Shares]]:
    scored = [record for record in records if record.verdict.excluded is None]
    return zip(scored, contributions([record.verdict for record in scored], ability), strict=True)


def name_of(record: Record) -> str:
    """The name that near copies of a task share; where it is not known, the task stands for itself."""
    return record.task_id if record.task is None else record.task.name


def share_of(records: Sequence[Record], counted: Sequence[bool]) -> Estimate:
    """The share of records that count."""
    cases = zip(records, counted, strict=True)
    return Estimate.from_cases(
        [Case(record.task_id, name_of(record), share_of_one(counts)) for record, counts in cases]
    )


AVERAGE = "average_performance"
"""The name of the metric."""


AbilityMetric: TypeAlias = tuple[Ability, str]
"""A metric of an ability."""


def average_weights(values: Mapping[AbilityMetric, float | None] | None = None) -> dict[AbilityMetric, float]:
    """How much each metric counts in the average: a quarter an ability, halved where it has two metrics.

    Args:
        values: what is known in percent; a metric that is declared to stand in the place of one of the
            paper's does so where it is known. Without values the metrics are the paper's.
    """
    known = values or {}
    weights: dict[AbilityMetric, float] = {}
    for ability, declared in load_paper_abilities().items():
        for metric in declared.averaged_metrics:
            place = ability, declared.replacements.get(metric, metric)
            place = place if known.get(place) is not None else (ability, metric)
            weights[place] = 1 / (len(PAPER_ABILITIES) * len(declared.averaged_metrics))
    return weights


def average_performance(values: Mapping[AbilityMetric, float | None]) -> float | None:
    """The mean over the four abilities in percent, or None unless all are known.

    ``(goal F1 + subgoal task success + action task success + (operator F1 + planner success) / 2) / 4``: the
    paper's section "Average Performance". Where it is known which plans work, that rate stands in the place
    of planner success.

    Args:
        values: (ability, metric) -> percent.
    """
    weights = average_weights(values)
    parts = [weight * value for place, weight in weights.items() if (value := values.get(place)) is not None]
    return sum(parts) if len(parts) == len(weights) else None


def keep_attempts(record: Record, attempts: int) -> Record:
    """The record as it would be if a task had no more attempts than so many; one without any is as it is."""
    made = record.attempts[:attempts]
    if not made:
        return record
    last = made[-1]
    return replace(
        record, response=last.response, verdict=last.verdict, explanation=last.explanation, attempts=made
    )


def max_attempts(records: Sequence[Record]) -> int:
    """How many attempts the tasks of a run could have; 0 where answers were not carried out."""
    if not any(record.attempts for record in records):
        return 0
    known = [AttemptOptions.from_experiment(record.experiment) for record in records]
    return max([1 + options.replans for options in known if options is not None])


def summarise_by_attempt(records: Sequence[Record]) -> list[Mapping[str, Rate]]:
    """The metrics of a run by the number of attempts, from 1 on.

    The errors are those of the last attempt that was made. Success never falls: a trial ends with it.
    """
    return [
        summarise([keep_attempts(record, number).verdict for record in records], records[0].ability)
        for number in range(1, max_attempts(records) + 1)
    ]


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


def outcome_of(record: Record) -> AnswerOutcome:
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
    metric = None if declared.combine_epochs is None else find_success_metric(ability)
    outcomes: Counter[AnswerOutcome] = Counter()
    by_goals: dict[int, list[Case]] = {}
    by_length: dict[int, list[Case]] = {}
    by_action: dict[str, list[Share]] = {}
    by_predicate: dict[str, list[Share]] = {}
    for record in records:
        came_to = outcome_of(record)
        outcomes[came_to] += 1
        if came_to in _NO_ANSWER:
            continue
        success = Case(record.task_id, name_of(record), _success(record, came_to, metric))
        if record.task is not None:
            by_goals.setdefault(record.task.goals, []).append(success)
            if declared.has_plans and record.task.annotated_steps is not None:
                by_length.setdefault(record.task.annotated_steps, []).append(success)
        if declared.interaction.uses_operator_tasks:
            _break_down_operators(cast("OperatorVerdict", record.verdict), by_action, by_predicate)
        for report, reached in goals_of(record):
            for name in report.predicates:
                by_predicate.setdefault(name, []).append(share_of_one(reached))
        for _, step in steps_of(record) if declared.has_plans else ():
            by_action.setdefault(step.call.name, []).append(share_of_one(step.outcome == EXECUTED))
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
            found = [*((part, _TWICE) for part in side.matched), *((part, ZERO_SHARE) for part in wrong)]
            for part, share in found:
                by_action.setdefault(operator.name, []).append(share)
                for predicate in verdict.clauses[part].predicates:
                    by_predicate.setdefault(predicate, []).append(share)


_TWICE = Share(2, 2)
"""The contribution of a match to F1, which is 2 TP / (2 TP + FP + FN)."""


def _rates(shares: Mapping[str, Sequence[Share]]) -> dict[str, Rate]:
    return {name: rate_of(found) for name, found in sorted(shares.items())}
