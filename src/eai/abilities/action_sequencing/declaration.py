"""Action sequencing, as records, metrics and tables know it."""

from __future__ import annotations

from eai.abilities import trajectory_metrics
from eai.abilities.declaration import AbilityDeclaration
from eai.abilities.protocol import Ability
from eai.abilities.share import Share, of_all
from eai.abilities.trajectory_metrics import goal_shares, times, times_additional
from eai.abilities.verdict import PlanVerdict
from eai.world.fault import FaultKind

_ENDING_FAULTS = (
    FaultKind.PARSING,
    FaultKind.HALLUCINATION,
    FaultKind.ARGUMENT_NUMBER,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.UNCATEGORISED,
)


def contributions(verdict: PlanVerdict) -> dict[str, Share]:
    """What one plan contributes to each rate; what it counts as is what its verdict says, or `Counted`."""
    counted = verdict.counted
    return {
        "task_success": of_all(verdict.success if counted is None else counted.success),
        "execution_success": of_all(verdict.executable),
        **{kind.value: of_all(times(verdict, kind)) for kind in _ENDING_FAULTS},
        "additional_step": of_all(times_additional(verdict)),
        **goal_shares(verdict.goals if counted is None else counted.goals),
    }


ACTION_SEQUENCING = AbilityDeclaration(
    ability=Ability.ACTION_SEQUENCING,
    title="Action sequencing",
    short="actions",
    verdict=PlanVerdict,
    contributions=contributions,
    outcome=trajectory_metrics.plan_outcome,
    columns=trajectory_metrics.COLUMNS,
    terminal=trajectory_metrics.TERMINAL,
    main=trajectory_metrics.MAIN,
    averaged=trajectory_metrics.AVERAGED,
    yes_no=trajectory_metrics.YES_NO,
)
