"""Metrics of a run, as its ability declares them, and numbers of answers by outcome (success or error).

Metrics by attempt are the metrics that a run would have with fewer attempts at each task. The average
performance of a model in a domain is defined as in the paper. A breakdown counts successes by a feature of
tasks or answers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias, cast

from eai.abilities.declaration import AnswerOutcome, get_declaration, load_declarations_of_paper_abilities
from eai.abilities.explanation import EXECUTED, GoalReport, StepReport
from eai.abilities.protocol import PAPER_ABILITIES, Ability
from eai.abilities.replanning_options import ReplanningOptions
from eai.abilities.verdict import EMPTY_SHARE as NO_SHARE
from eai.abilities.verdict import (
    ZERO_SHARE,
    PlanVerdict,
    ShareByMetric,
    Verdict,
    make_rate_contribution_of_answer,
)
from eai.base.grouping import group_pairs
from eai.results.certainty import TaskRateContribution
from eai.results.rate import NOTHING, Rate, compute_rate, compute_rates
from eai.results.record import Record
from eai.results.repeats import find_success_metric
from eai.results.table import Estimate
from eai.tasks.share import Share

if TYPE_CHECKING:
    from eai.abilities.transition_modeling.verdict import OperatorVerdict


def compute_metric_rates(verdicts: Sequence[Verdict], ability: Ability) -> dict[str, Rate]:
    """Return a mapping from metrics to rates, for an ability's metrics in the paper's tables.

    Excluded verdicts do not count. Metrics without any verdict are present as rates of 0 of 0.
    """
    declared = get_declaration(ability)
    nothing = dict.fromkeys(declared.contributions(declared.verdict()), NOTHING)
    return {**nothing, **compute_rates(compute_metric_contributions(verdicts, ability))}


def compute_metric_contributions(verdicts: Sequence[Verdict], ability: Ability) -> Iterator[ShareByMetric]:
    """Yield the contributions of each verdict to all metrics, in order. Excluded verdicts do not count.

    They are yielded one by one to save memory in long runs.
    """
    declared = get_declaration(ability)
    scored = [verdict for verdict in verdicts if verdict.excluded is None]
    void = dict.fromkeys(
        (metric for verdict in scored for metric in declared.missing_metrics(verdict)), NO_SHARE
    )
    shares = map(declared.contributions, scored)
    return ({**share, **void} for share in shares) if void else shares


def compute_metric_contributions_by_task(records: Sequence[Record]) -> dict[str, ShareByMetric]:
    """Return each task's contribution to every metric of its ability. Excluded records are left out."""
    return {
        record.task_id: shares
        for record, shares in _pair_records_with_metric_contributions(records, records[0].ability)
    }


def make_contributions_by_metric(
    records: Sequence[Record], ability: Ability
) -> dict[str, list[TaskRateContribution]]:
    """Return for each metric the contributions of a run's records to the metric.

    Excluded records do not count. If no record has an answer, nothing contributes to the metrics.
    """
    if records and all(record.unanswered is not None for record in records):
        declared = get_declaration(ability)
        return {metric: [] for metric in declared.contributions(declared.verdict())}
    return group_pairs(
        (metric, TaskRateContribution(task, name, share))
        for record, shares in _pair_records_with_metric_contributions(records, ability)
        for task, name in [(record.task_id, find_task_name(record))]
        for metric, share in shares.items()
    )


def _pair_records_with_metric_contributions(
    records: Sequence[Record], ability: Ability
) -> Iterator[tuple[Record, ShareByMetric]]:
    scored = [record for record in records if record.verdict.excluded is None]
    return zip(
        scored, compute_metric_contributions([record.verdict for record in scored], ability), strict=True
    )


def find_task_name(record: Record) -> str:
    """Return the name that near copies of a task share; the task's id if the name is unknown."""
    return record.task_id if record.task is None else record.task.name


def estimate_share(records: Sequence[Record], counted: Sequence[bool]) -> Estimate:
    """Return the share of scored answers for which ``counted`` is true, as an estimate with an interval."""
    cases = zip(records, counted, strict=True)
    return Estimate.from_task_rate_contributions(
        [
            TaskRateContribution(
                record.task_id, find_task_name(record), make_rate_contribution_of_answer(is_counted)
            )
            for record, is_counted in cases
        ]
    )


AVERAGE = "average_performance"
"""Name of the metric of average performance."""


AbilityMetric: TypeAlias = tuple[Ability, str]
"""A kind of question (ability), and the name of one of the metrics of its answers."""


def compute_weights_of_averaged_metrics(
    metric_values: Mapping[AbilityMetric, float | None] | None = None,
) -> dict[AbilityMetric, float]:
    """Return the weight of each metric in the average over the paper's four abilities.

    The metrics of an ability share its weight of 1/4 equally.

    Args:
        metric_values: known values in percent; None if no value is known. If a metric has a replacement
            (`AbilityDeclaration.replacements`) with a known value, the replacement gets the metric's weight.
    """
    known_values = metric_values or {}
    weights: dict[AbilityMetric, float] = {}
    for ability, declared in load_declarations_of_paper_abilities().items():
        for metric in declared.averaged_metrics:
            metric_key = ability, declared.replacements.get(metric, metric)
            metric_key = metric_key if known_values.get(metric_key) is not None else (ability, metric)
            weights[metric_key] = 1 / (len(PAPER_ABILITIES) * len(declared.averaged_metrics))
    return weights


def compute_average_performance(values: Mapping[AbilityMetric, float | None]) -> float | None:
    """Return the mean over the four abilities in percent; None if an ability has no known value.

    ``(goal F1 + subgoal task success + action task success + (operator F1 + planner success) / 2) / 4``: the
    paper's section "Average Performance". Planner success is the rate of tasks for which a planner finds a
    plan with the answer's operators. If the rate of plans that also work is known, it replaces planner
    success.

    Args:
        values: mapping from ability and metric to percent.
    """
    weights = compute_weights_of_averaged_metrics(values)
    parts = [weight * value for key, weight in weights.items() if (value := values.get(key)) is not None]
    return sum(parts) if len(parts) == len(weights) else None


def drop_later_attempts(record: Record, attempts: int) -> Record:
    """Return the record that a task would have if only ``attempts`` attempts had been allowed.

    A record without attempts does not change.
    """
    kept_attempts = record.attempts[:attempts]
    if not kept_attempts:
        return record
    last = kept_attempts[-1]
    return replace(
        record,
        response=last.response,
        verdict=last.verdict,
        explanation=last.explanation,
        attempts=kept_attempts,
    )


def find_max_attempts_per_task(records: Sequence[Record]) -> int:
    """Return how many attempts a run allows at each task; 0 if no record has attempts."""
    if not any(record.attempts for record in records):
        return 0
    options_of_records = [ReplanningOptions.from_experiment(record.experiment) for record in records]
    return max([1 + options.replans for options in options_of_records if options is not None])


def compute_rates_by_attempt(records: Sequence[Record]) -> list[Mapping[str, Rate]]:
    """Return the metrics of a run with at most 1, 2, ... attempts at each task.

    Errors are those of the last attempt. Success never falls, because a task is not tried again after a
    success.
    """
    return [
        compute_metric_rates(
            [drop_later_attempts(record, number).verdict for record in records], records[0].ability
        )
        for number in range(1, find_max_attempts_per_task(records) + 1)
    ]


_NO_ANSWER = frozenset({AnswerOutcome.EXCLUDED, AnswerOutcome.NOT_ANSWERED})
"""Outcomes that tables by goals, length, action and predicate leave out: there is no scored answer."""


_OUTCOMES_BEFORE_STAGE = {
    "readable": AnswerOutcome.PARSING,
    "known": AnswerOutcome.HALLUCINATION,
    "well_formed": AnswerOutcome.ARGUMENT_NUMBER,
}
"""Mapping from each check of plans, such as ``readable``, to the outcome of plans that fail the check."""


@dataclass(frozen=True, slots=True)
class AnswerBreakdown:
    """The answers of one run by their outcomes (success, or a kind of failure).

    Attributes:
        outcomes: number of answers with each outcome.
        flow: number of scored answers (``answers``), then number of answers that pass each check.
            The checks are ``readable``, ``known`` (no unknown names), ``well_formed`` (right number of
            arguments), ``executed`` and ``reached`` (the goals). None for abilities without plans.
        by_goals: mapping from a number of goals to the successes in tasks with this number of goals. A
            success is 0 or 1, or the mean over several answers to a task.
        by_length: mapping from the length of the data set's own plan to the success of each answer to a task
            with such a plan. The length of the answer's plan is not used: a plan that fails early would count
            as short.
        by_action: mapping from each operator to the share of executed steps among its tried steps, which
            include additional steps (they are not executed); F1 in transition modeling.
        by_predicate: mapping from each predicate to the share of reached goals among the goals that mention
            it; F1 in transition modeling.
    """

    outcomes: Mapping[AnswerOutcome, int]
    flow: Mapping[str, int] | None
    by_goals: Mapping[int, Sequence[TaskRateContribution]]
    by_length: Mapping[int, Sequence[TaskRateContribution]]
    by_action: Mapping[str, Rate]
    by_predicate: Mapping[str, Rate]


def find_answer_outcome(record: Record) -> AnswerOutcome:
    """Return the outcome of an answer: success, a kind of failure, or that it is missing or excluded."""
    if record.verdict.excluded is not None:
        return AnswerOutcome.EXCLUDED
    if record.unanswered is not None:
        return AnswerOutcome.NOT_ANSWERED
    return get_declaration(record.ability).outcome(record.verdict)


def break_down_records(records: Iterable[Record], ability: Ability) -> AnswerBreakdown:
    """Return the breakdown of a run's records (scored answers), all of one ability.

    Missing and excluded answers count only as outcomes. Records without the features of their tasks are left
    out of breakdowns by task.
    """
    declared = get_declaration(ability)
    metric = None if declared.combine_epochs is None else find_success_metric(ability)
    outcomes: Counter[AnswerOutcome] = Counter()
    by_goals: dict[int, list[TaskRateContribution]] = {}
    by_length: dict[int, list[TaskRateContribution]] = {}
    by_action: dict[str, list[Share]] = {}
    by_predicate: dict[str, list[Share]] = {}
    for record in records:
        answer_outcome = find_answer_outcome(record)
        outcomes[answer_outcome] += 1
        if answer_outcome in _NO_ANSWER:
            continue
        success = TaskRateContribution(
            record.task_id,
            find_task_name(record),
            _make_contribution_to_success_rate(record, answer_outcome, metric),
        )
        if record.task is not None:
            by_goals.setdefault(record.task.goals, []).append(success)
            if declared.answers_are_plans and record.task.annotated_steps is not None:
                by_length.setdefault(record.task.annotated_steps, []).append(success)
        if declared.interaction.uses_operator_tasks:
            _add_clause_scores_by_action_and_predicate(
                cast("OperatorVerdict", record.verdict), by_action, by_predicate
            )
        for report, reached in list_goals_and_whether_reached(record):
            for name in report.predicates:
                by_predicate.setdefault(name, []).append(make_rate_contribution_of_answer(reached))
        for _, step in list_reported_steps(record) if declared.answers_are_plans else ():
            by_action.setdefault(step.call.name, []).append(
                make_rate_contribution_of_answer(step.outcome == EXECUTED)
            )
    return AnswerBreakdown(
        {kind: outcomes[kind] for kind in AnswerOutcome if outcomes[kind]},
        _count_answers_reaching_each_stage(outcomes) if declared.answers_are_plans else None,
        dict(sorted(by_goals.items())),
        dict(sorted(by_length.items())),
        _compute_rate_by_name(by_action),
        _compute_rate_by_name(by_predicate),
    )


def _make_contribution_to_success_rate(
    record: Record, answer_outcome: AnswerOutcome, metric: str | None
) -> Share:
    """Return an answer's contribution to the success metric: 0 or 1, or the mean over several answers."""
    if metric is None:
        return Share(answer_outcome is AnswerOutcome.SUCCESS, 1)
    return get_declaration(record.ability).contributions(record.verdict)[metric]


def _count_answers_reaching_each_stage(outcomes: Mapping[AnswerOutcome, int]) -> dict[str, int]:
    flow = {"answers": sum(count for kind, count in outcomes.items() if kind not in _NO_ANSWER)}
    remaining = flow["answers"]
    for stage, answer_outcome in _OUTCOMES_BEFORE_STAGE.items():
        flow[stage] = remaining = remaining - outcomes.get(answer_outcome, 0)
    reached = outcomes.get(AnswerOutcome.SUCCESS, 0)
    return {**flow, "executed": reached + outcomes.get(AnswerOutcome.GOAL_MISSED, 0), "reached": reached}


def list_goals_and_whether_reached(record: Record) -> Iterator[tuple[GoalReport, bool]]:
    """Yield each goal in the explanation of a record, with whether it counts as reached."""
    reports = () if record.explanation is None else record.explanation.goals
    counted = record.verdict.goals_satisfied if isinstance(record.verdict, PlanVerdict) else ()
    reached = counted if len(counted) == len(reports) else [report.satisfied for report in reports]
    yield from zip(reports, reached, strict=True)


def list_reported_steps(record: Record) -> Iterator[tuple[int, StepReport]]:
    """Yield the steps at which an action was tried: the step's number, from 0, and its explanation."""
    steps = () if record.explanation is None else record.explanation.steps
    yield from (
        (number, step) for number, step in enumerate(steps) if record.verdict.is_step_an_action(number)
    )


def _add_clause_scores_by_action_and_predicate(
    verdict: OperatorVerdict, by_action: dict[str, list[Share]], by_predicate: dict[str, list[Share]]
) -> None:
    """Add each clause of a precondition or effect, as right or wrong, to its operator and its predicates."""
    for operator in verdict.operators:
        for side in (operator.precondition, operator.effect):
            wrong = (*side.additional, *side.missing)
            shares = [
                *((clause, _MATCH) for clause in side.matched),
                *((clause, ZERO_SHARE) for clause in wrong),
            ]
            for clause, share in shares:
                by_action.setdefault(operator.name, []).append(share)
                for predicate in verdict.clauses[clause].predicates:
                    by_predicate.setdefault(predicate, []).append(share)


_MATCH = Share(2, 2)
"""Numerator and denominator that a right clause (a true positive) adds to F1: 2 TP / (2 TP + FP + FN)."""


def _compute_rate_by_name(shares_by_name: Mapping[str, Sequence[Share]]) -> dict[str, Rate]:
    return {name: compute_rate(shares_of_name) for name, shares_of_name in sorted(shares_by_name.items())}
