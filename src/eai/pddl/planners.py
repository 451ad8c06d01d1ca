"""The planners that judge operators, by choice."""

from __future__ import annotations

from dataclasses import replace

from eai.pddl.fast_downward import FastDownward, machine_memory_mib
from eai.pddl.planning import PddlPlanner, PlannerChoice, PlannerTerms
from eai.pddl.search import BuiltInPlanner
from eai.planning.search import Limits

FIRST_LIMITS = Limits(300)
"""The limits of the built-in search before Fast Downward is asked, which is then the quicker of the two."""


def resolve_choice(choice: PlannerChoice) -> PlannerChoice:
    """The planner that a choice means in this environment: Fast Downward is used where it is installed."""
    if choice is not PlannerChoice.AUTO:
        return choice
    return PlannerChoice.FULL if FastDownward.is_installed() else PlannerChoice.BUILT_IN


def make_planner(
    choice: PlannerChoice, cpu_seconds: int, terms: PlannerTerms | None = None
) -> PddlPlanner | None:
    """The planner that may take so long for one task, or None if none is to be asked.

    Args:
        choice: which.
        cpu_seconds: how long Fast Downward may take, where the terms do not say.
        terms: on what terms it is asked.

    Raises:
        DataError: Fast Downward is not installed; the message says how to install it.
    """
    terms = terms or PlannerTerms()
    match resolve_choice(choice):
        case PlannerChoice.NONE:
            return None
        case PlannerChoice.BUILT_IN:
            return BuiltInPlanner()
        case PlannerChoice.FAST_DOWNWARD:
            return _make_fast_downward(cpu_seconds, terms)
        case PlannerChoice.FULL | PlannerChoice.AUTO:
            return BuiltInPlanner(FIRST_LIMITS, _make_fast_downward(cpu_seconds, terms))


def _make_fast_downward(cpu_seconds: int, terms: PlannerTerms) -> FastDownward:
    """Fast Downward, of which no more run at a time than there is memory for."""
    planner = FastDownward.find_installed(terms.seconds or cpu_seconds)
    memory = machine_memory_mib() if terms.memory_mib is None else terms.memory_mib
    remark = "" if planner.cpu_seconds == cpu_seconds else f" ({planner.cpu_seconds} s)"
    if terms.memory_mib is not None and memory < planner.memory_mib:
        planner = replace(planner, memory_mib=memory)
        remark += f" ({memory} MiB)"
    slots = None if terms.folder is None else (max(1, memory // planner.memory_mib), terms.folder)
    return replace(planner, slots=slots, remark=remark)
