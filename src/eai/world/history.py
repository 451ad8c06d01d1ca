"""History rules: whether what a failed check misses was there before."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

from eai.world.condition import all_of
from eai.world.executable import Failure, first_failing
from eai.world.fault import FaultKind
from eai.world.frame import Binding, Truth
from eai.world.past import Past
from eai.world.state import State

HistoryRule: TypeAlias = Callable[[Failure, Binding, Past], int | None]
"""Judges a failed check against the past: the number of the earlier state that makes it a wrong order.

Its last argument is the trajectory so far: the initial state, then the state after each executed step. None
means that the step which should have prepared the action was never taken.
"""


def each_held_before(failure: Failure, binding: Binding, past: Past) -> int | None:
    """A history rule: all that a missing step's check seeks held at some time, not necessarily at once.

    Returns the latest state by which all of it had been seen.
    """
    if failure.check.check.fault is not FaultKind.MISSING_STEP:
        return None
    latest = 0
    for number, sought in enumerate(failure.check.sought):
        question = (failure.check, number, failure.arguments)
        found = past.latest(question, partial(_in_state, sought, binding))
        if found is None:
            return None
        latest = max(latest, found)
    return latest


def _in_state(truth: Truth, binding: Binding, state: State) -> bool:
    return truth(state, binding)


def was_possible_before(failure: Failure, binding: Binding, past: Past) -> int | None:
    """A history rule: in a state before the last one no check failed, and all that this check seeks held.

    Returns the latest such state.
    """
    if past.before is None:
        return None
    had_it = all_of(failure.check.sought)

    def sufficed(state: State) -> bool:
        return had_it(state, binding) and first_failing(failure.checks, state, binding) is None

    return past.before.latest((failure.check, failure.arguments), sufficed)
