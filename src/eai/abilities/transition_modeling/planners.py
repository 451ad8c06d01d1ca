"""The planners that judge operators, by choice."""

from __future__ import annotations

from eai.abilities.protocol import Domain
from eai.abilities.suite import PlannerChoice
from eai.pddl.fast_downward import FastDownward, Limits
from eai.pddl.planner import BuiltInPlanner, TieredPlanner
from eai.pddl.planning import PddlPlanner
from eai.pddl.search import Effort

CPU_SECONDS = {Domain.VIRTUALHOME: 100, Domain.BEHAVIOR: 200}
"""How long a planner may take for one task (the reference's limits)."""

FIRST_EFFORT = Effort(full=300)
"""What the built-in search may do before Fast Downward is asked, which is then the quicker of the two."""


def make_planner(choice: PlannerChoice, domain: Domain) -> PddlPlanner | None:
    """The planner for a domain, or None if none is to be asked.

    Raises:
        DataError: Fast Downward is not installed; the message says how to install it.
    """
    match choice:
        case PlannerChoice.NONE:
            return None
        case PlannerChoice.BUILT_IN:
            return BuiltInPlanner()
        case PlannerChoice.FAST_DOWNWARD:
            return FastDownward.installed(Limits(cpu_seconds=CPU_SECONDS[domain]))
        case PlannerChoice.FULL:
            authority = FastDownward.installed(Limits(cpu_seconds=CPU_SECONDS[domain]))
            return TieredPlanner(BuiltInPlanner(FIRST_EFFORT), authority)
