"""Choose the planner that checks whether the operators in answers allow a plan."""

from __future__ import annotations

from dataclasses import replace

from eai.pddl.fast_downward import FastDownward, measure_machine_memory_mib
from eai.pddl.planning import PddlPlanner, PlannerChoice, PlannerLimits
from eai.pddl.search import BuiltInPlanner
from eai.planning.search import Limits

FIRST_LIMITS = Limits(300)
"""Limits of the built-in search, after which Fast Downward searches.

With larger limits, the two searches together take longer.
"""


def resolve_automatic_choice(choice: PlannerChoice) -> PlannerChoice:
    """Return a choice of planner, in which ``full`` or ``built_in`` replaces ``auto``.

    If Fast Downward is installed in this environment, ``full`` replaces ``auto``.
    """
    if choice is not PlannerChoice.AUTO:
        return choice
    return PlannerChoice.FULL if FastDownward.is_installed() else PlannerChoice.BUILT_IN


def make_planner(
    choice: PlannerChoice, cpu_seconds: int, limits: PlannerLimits | None = None
) -> PddlPlanner | None:
    """Return the chosen planner, or None if no planner is chosen.

    Args:
        choice: the choice of the planner.
        cpu_seconds: CPU seconds of Fast Downward for one task, unless ``limits`` has another number.
        limits: the user's limits of planners.

    Raises:
        DataError: Fast Downward is missing in this environment. The message names the install command.
    """
    limits = limits or PlannerLimits()
    match resolve_automatic_choice(choice):
        case PlannerChoice.NONE:
            return None
        case PlannerChoice.BUILT_IN:
            return BuiltInPlanner()
        case PlannerChoice.FAST_DOWNWARD:
            return _make_fast_downward(cpu_seconds, limits)
        case PlannerChoice.FULL | PlannerChoice.AUTO:
            return BuiltInPlanner(FIRST_LIMITS, _make_fast_downward(cpu_seconds, limits))


def _make_fast_downward(cpu_seconds: int, limits: PlannerLimits) -> FastDownward:
    """Return Fast Downward, limited to as many calls at a time as fit into memory."""
    planner = FastDownward.find_installed(limits.seconds or cpu_seconds)
    memory = measure_machine_memory_mib() if limits.memory_mib is None else limits.memory_mib
    remark = "" if planner.cpu_seconds == cpu_seconds else f" ({planner.cpu_seconds} s)"
    if limits.memory_mib is not None and memory < planner.memory_mib:
        planner = replace(planner, memory_mib=memory)
        remark += f" ({memory} MiB)"
    slots = None if limits.folder is None else (max(1, memory // planner.memory_mib), limits.folder)
    return replace(planner, slots=slots, remark=remark)
