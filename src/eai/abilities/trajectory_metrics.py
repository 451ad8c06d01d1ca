"""The measures that plans and subgoals share (tables "trajectory evaluation" and "goal satisfaction")."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from eai.abilities.declaration import (
    AbilityDeclaration,
    AnswerOutcome,
    MetricColumn,
    SingleTurn,
    error_outcome,
    label_of,
)
from eai.abilities.protocol import Ability
from eai.abilities.share import Share, Shares
from eai.abilities.task import GoalKind
from eai.abilities.verdict import GoalTallies, PlanVerdict, Tally
from eai.world.fault import FaultKind

SUCCESS, GRAMMAR, RUNTIME, SATISFIED = "Success", "Grammar errors", "Runtime errors", "Satisfied goals"
"""The groups of columns."""

KINDS = tuple(kind.value for kind in GoalKind)
GOAL_METRICS = (*(f"{kind}_goal" for kind in KINDS), "total_goal")

COLUMNS = (
    MetricColumn("task_success", SUCCESS, "Task"),
    MetricColumn("execution_success", SUCCESS, "Execution"),
    MetricColumn("parsing", GRAMMAR, "Parsing", False),
    MetricColumn("hallucination", GRAMMAR, "Hallucination", False),
    MetricColumn("argument_number", GRAMMAR, "Arguments", False),
    MetricColumn("wrong_order", RUNTIME, "Wrong order", False),
    MetricColumn("missing_step", RUNTIME, "Missing step", False),
    MetricColumn("affordance", RUNTIME, "Affordance", False),
    MetricColumn("additional_step", RUNTIME, "Additional step", False),
    *(MetricColumn(metric, SATISFIED, label_of(metric.removesuffix("_goal"))) for metric in GOAL_METRICS),
)
"""The columns of the paper's tables."""

P = TypeVar("P", bound=PlanVerdict)


def on_trajectories(
    ability: Ability,
    asked: SingleTurn,
    title: str,
    short: str,
    verdict: type[P],
    contributions: Callable[[P], Shares],
) -> AbilityDeclaration[P]:
    """The declaration of an ability whose answers are executed."""
    main = {"task_success": "Task", "execution_success": "Execution"}
    return AbilityDeclaration(
        ability=ability,
        asked=asked,
        title=title,
        short=short,
        verdict=verdict,
        contributions=contributions,
        outcome=plan_outcome,
        columns=COLUMNS,
        terminal=tuple(column.metric for column in COLUMNS),
        main=main,
        averaged=("task_success",),
        yes_no=frozenset(main),
    )


def times(verdict: PlanVerdict, kind: FaultKind) -> int:
    """How often a kind of error that ends a plan counts."""
    if verdict.counted is not None:
        return dict(verdict.counted.errors).get(kind, 0)
    return int(verdict.error is not None and verdict.error.kind is kind)


def times_additional(verdict: PlanVerdict) -> int:
    """How often additional steps count: once an answer, unless the verdict says otherwise."""
    if verdict.counted is not None:
        return times(verdict, FaultKind.ADDITIONAL_STEP)
    return int(bool(verdict.additional_steps))


def goal_shares(goals: GoalTallies | None) -> Shares:
    """The contributions of one answer to goal satisfaction rates; nothing where its goals are not known."""
    known: tuple[Tally, ...] = (Tally(0, 0),) * len(KINDS) if goals is None else goals
    whole = Share(sum(t.satisfied for t in known), sum(t.total for t in known))
    return dict(zip(GOAL_METRICS, (*(Share(*tally) for tally in known), whole), strict=True))


def plan_outcome(verdict: PlanVerdict) -> AnswerOutcome:
    """The outcome of a plan."""
    if verdict.success:
        return AnswerOutcome.SUCCESS
    return error_outcome(verdict) or AnswerOutcome.GOAL_MISSED
