"""Action sequencing, as records, metrics and tables know it."""

from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.abilities.share import Share, of_all
from eai.abilities.trajectory_metrics import goal_shares, on_trajectories, times, times_additional
from eai.abilities.verdict import PlanVerdict
from eai.world.fault import FaultKind

_ENDING_FAULTS = {
    kind.value: kind
    for kind in (
        FaultKind.PARSING,
        FaultKind.HALLUCINATION,
        FaultKind.ARGUMENT_NUMBER,
        FaultKind.WRONG_ORDER,
        FaultKind.MISSING_STEP,
        FaultKind.AFFORDANCE,
        FaultKind.UNCATEGORISED,
    )
}


def contributions(verdict: PlanVerdict) -> dict[str, Share]:
    """What one plan contributes to each rate; what it counts as is what its verdict says, or `Counted`."""
    counted = verdict.counted
    return {
        "task_success": of_all(verdict.success if counted is None else counted.success),
        "execution_success": of_all(verdict.executable),
        **{name: of_all(times(verdict, kind)) for name, kind in _ENDING_FAULTS.items()},
        "additional_step": of_all(times_additional(verdict)),
        **goal_shares(verdict.goals if counted is None else counted.goals),
    }


ACTION_SEQUENCING = on_trajectories(
    Ability.ACTION_SEQUENCING, "Action sequencing", "actions", PlanVerdict, contributions
)
