"""The planners that judge operators, by choice."""

from __future__ import annotations

from eai.pddl.fast_downward import FastDownward, PlannerLimits
from eai.pddl.planner import BuiltInPlanner, TieredPlanner
from eai.pddl.planning import PddlPlanner, PlannerChoice
from eai.pddl.search import Effort

FIRST_EFFORT = Effort(full=300)
"""What the built-in search may do before Fast Downward is asked, which is then the quicker of the two."""


def make_planner(choice: PlannerChoice, cpu_seconds: int) -> PddlPlanner | None:
    """The planner that may take so long for one task, or None if none is to be asked.

    Raises:
        DataError: Fast Downward is not installed; the message says how to install it.
    """
    match choice:
        case PlannerChoice.NONE:
            return None
        case PlannerChoice.BUILT_IN:
            return BuiltInPlanner()
        case PlannerChoice.FAST_DOWNWARD:
            return FastDownward.installed(PlannerLimits(cpu_seconds=cpu_seconds))
        case PlannerChoice.FULL:
            authority = FastDownward.installed(PlannerLimits(cpu_seconds=cpu_seconds))
            return TieredPlanner(BuiltInPlanner(FIRST_EFFORT), authority)
