"""The planners that judge operators, by choice."""

from __future__ import annotations

from eai.abilities.protocol import member
from eai.pddl.fast_downward import FastDownward, PlannerLimits
from eai.pddl.planner import BuiltInPlanner, TieredPlanner
from eai.pddl.planning import PddlPlanner, PlannerChoice
from eai.pddl.search import Effort

FIRST_EFFORT = Effort(full=300)
"""What the built-in search may do before Fast Downward is asked, which is then the quicker of the two."""


def planner_of(name: PlannerChoice | str) -> PlannerChoice:
    """The choice of this name.

    Raises:
        InputError: there is none.
    """
    return member(PlannerChoice, name, "planner")


def available(choice: PlannerChoice) -> PlannerChoice:
    """What a choice comes to in this environment: Fast Downward is used where it is installed."""
    if choice is not PlannerChoice.AUTO:
        return choice
    return PlannerChoice.FULL if FastDownward.is_installed() else PlannerChoice.BUILT_IN


def make_planner(choice: PlannerChoice, cpu_seconds: int) -> PddlPlanner | None:
    """The planner that may take so long for one task, or None if none is to be asked.

    Raises:
        DataError: Fast Downward is not installed; the message says how to install it.
    """
    match available(choice):
        case PlannerChoice.NONE:
            return None
        case PlannerChoice.BUILT_IN:
            return BuiltInPlanner()
        case PlannerChoice.FAST_DOWNWARD:
            return FastDownward.installed(PlannerLimits(cpu_seconds=cpu_seconds))
        case PlannerChoice.FULL | PlannerChoice.AUTO:
            authority = FastDownward.installed(PlannerLimits(cpu_seconds=cpu_seconds))
            return TieredPlanner(BuiltInPlanner(FIRST_EFFORT), authority)
