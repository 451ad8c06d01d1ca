"""The past of a trajectory, and history rules: whether what a failed check misses was there before.

Trajectories that begin alike share their beginning.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial
from typing import TypeAlias

from eai.world.condition import conjunction
from eai.world.executable import Failure, find_failing_check
from eai.world.fault import FaultKind
from eai.world.frame import FrameBinding, Truth
from eai.world.state import State


class History:
    """A state with all those before it.

    Trajectories that begin alike share their beginning, so that going on costs the same however long they
    are. So does asking the same again some states later: what was found out about a past is remembered there.

    Args:
        state: the last of the states.
        before: those before it; None where it is the initial one.

    Attributes:
        state: the last of the states.
        before: those before it, or None.
        number: how many states are before it.
    """

    __slots__ = ("_latest", "before", "number", "state")

    def __init__(self, state: State, before: History | None = None) -> None:
        self.state = state
        self.before = before
        self.number: int = 0 if before is None else before.number + 1
        self._latest: dict[Hashable, int | None] = {}

    def extended(self, state: State) -> History:
        """The past after one more state."""
        return History(state, self)

    @property
    def states(self) -> tuple[State, ...]:
        """All states, from the initial one on."""
        found = []
        moment: History | None = self
        while moment is not None:
            found.append(moment.state)
            moment = moment.before
        return tuple(reversed(found))

    def last_where(self, question: Hashable, test: Callable[[State], bool]) -> int | None:
        """The number of the latest state that passes a test, or None.

        Args:
            question: stands for the test: where it is the same, so is what the test says of any state.
            test: looks at a state.
        """
        moment: History | None = self
        found = None
        while moment is not None:
            if question in moment._latest:
                found = moment._latest[question]
                break
            if test(moment.state):
                found = moment.number
                break
            moment = moment.before
        self._latest[question] = found
        return found


HistoryRule: TypeAlias = Callable[[Failure, FrameBinding, History], int | None]
"""Judges a failed check against the past: the number of the earlier state that makes it a wrong order.

Its last argument is the trajectory so far: the initial state, then the state after each executed step. None
means that the step which should have prepared the action was never taken.
"""


def conditions_held_before(failure: Failure, binding: FrameBinding, history: History) -> int | None:
    """A history rule: all that a missing step's check seeks held at some time, not necessarily at once.

    Returns the latest state by which all of it had been seen.
    """
    if failure.check.check.fault is not FaultKind.MISSING_STEP:
        return None
    latest = 0
    for number, sought in enumerate(failure.check.sought):
        question = (failure.check, number, failure.arguments)
        found = history.last_where(question, partial(_in_state, sought, binding))
        if found is None:
            return None
        latest = max(latest, found)
    return latest


def _in_state(truth: Truth, binding: FrameBinding, state: State) -> bool:
    return truth(state, binding)


def was_possible_before(failure: Failure, binding: FrameBinding, history: History) -> int | None:
    """A history rule: in a state before the last one no check failed, and all that this check seeks held.

    Returns the latest such state.
    """
    if history.before is None:
        return None
    had_it = conjunction(failure.check.sought)

    def sufficed(state: State) -> bool:
        return had_it(state, binding) and find_failing_check(failure.checks, state, binding) is None

    return history.before.last_where((failure.check, failure.arguments), sufficed)
