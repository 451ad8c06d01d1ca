"""The paper's metrics of action sequencing (tables "trajectory evaluation" and "goal satisfaction")."""

from __future__ import annotations

from eai.abilities.protocol import Protocol
from eai.abilities.verdict import Counted, GoalTallies, PlanVerdict, Tally, Verdict
from eai.metrics.goals import GOAL_COLUMNS, goal_rates
from eai.metrics.rate import Rate, share
from eai.world.fault import FaultKind

TRAJECTORY_COLUMNS = (
    "task_success",
    "execution_success",
    "parsing",
    "hallucination",
    "argument_number",
    "wrong_order",
    "missing_step",
    "affordance",
    "additional_step",
)
"""The columns of the paper's table "trajectory evaluation"."""

TABLE_COLUMNS = (*TRAJECTORY_COLUMNS, *GOAL_COLUMNS)
"""What a terminal shows: the paper's columns."""

_NO_GOALS = GoalTallies(Tally(0, 0), Tally(0, 0), Tally(0, 0))
"""The goals of an answer whose goals are not known."""

_ENDING_FAULTS = (
    FaultKind.PARSING,
    FaultKind.HALLUCINATION,
    FaultKind.ARGUMENT_NUMBER,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.UNCATEGORISED,
)


def contribution(verdict: Verdict, domain: str, protocol: Protocol) -> dict[str, Rate]:
    """What one answer contributes to each rate: what it counts as is what its verdict says, or `Counted`."""
    counted = verdict.counted if isinstance(verdict, PlanVerdict) else None
    if counted is None:
        counted = _as_told(verdict)
    times = dict(counted.errors)
    return {
        "task_success": share(counted.success),
        "execution_success": share(verdict.executable),
        **{kind.value: share(times.get(kind, 0)) for kind in _ENDING_FAULTS},
        "additional_step": share(times.get(FaultKind.ADDITIONAL_STEP, 0)),
        **goal_rates(counted.goals._asdict()),
    }


def _as_told(verdict: Verdict) -> Counted:
    """What an answer counts as where that is what its verdict says: an error, and additional steps, once."""
    ended = () if verdict.error is None else ((verdict.error.kind, 1),)
    additional = ((FaultKind.ADDITIONAL_STEP, 1),) if verdict.additional_steps else ()
    return Counted(bool(verdict.success), verdict.goals or _NO_GOALS, (*ended, *additional))
