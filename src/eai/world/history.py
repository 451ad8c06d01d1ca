"""Histories of states, and history rules, which search them for the condition of a failed check.

Trajectories with equal beginnings share a history.
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
    """A state with all states before it.

    Histories share their beginnings, so adding a state takes constant time. A history caches the answers of
    `last_where`. If the same question is asked some states later, only the new states are tested.

    Args:
        state: the last state.
        before: the history before the last state; None for the initial state.

    Attributes:
        state: the last state.
        before: the history before the last state, or None.
        number: number of states before the last one.
    """

    __slots__ = ("_answers", "before", "number", "state")

    def __init__(self, state: State, before: History | None = None) -> None:
        self.state = state
        self.before = before
        self.number: int = 0 if before is None else before.number + 1
        self._answers: dict[Hashable, int | None] = {}

    def extend(self, state: State) -> History:
        """Return the history with one more state."""
        return History(state, self)

    @property
    def states(self) -> tuple[State, ...]:
        """All states, the initial one first."""
        states = []
        history: History | None = self
        while history is not None:
            states.append(history.state)
            history = history.before
        return tuple(reversed(states))

    def last_where(self, question: Hashable, test: Callable[[State], bool]) -> int | None:
        """Return the number of the last state that passes a test, or None.

        Args:
            question: a key for the test: equal keys must stand for equal tests.
            test: the test.
        """
        history: History | None = self
        number = None
        while history is not None:
            if question in history._answers:
                number = history._answers[question]
                break
            if test(history.state):
                number = history.number
                break
            history = history.before
        self._answers[question] = number
        return number


HistoryRule: TypeAlias = Callable[[Failure, FrameBinding, History], int | None]
"""Function that decides whether a failed check is a wrong order: it returns the number of an earlier state.

In this state the condition of the check held. The last argument of the function is the history: the initial
state, then the state after each executed step. The function returns None if the step that should have
prepared the action was never taken.
"""


def conditions_held_before(failure: Failure, binding: FrameBinding, history: History) -> int | None:
    """A history rule: each history condition of a check of missing steps held before, each in any state.

    Returns the number of the last state in which such a condition held; None if one never held.
    """
    if failure.check.check.fault is not FaultKind.MISSING_STEP:
        return None
    latest = 0
    for index, condition in enumerate(failure.check.history_conditions):
        question = (failure.check, index, failure.arguments)
        number = history.last_where(question, partial(_holds, condition, binding))
        if number is None:
            return None
        latest = max(latest, number)
    return latest


def _holds(truth: Truth, binding: FrameBinding, state: State) -> bool:
    return truth(state, binding)


def was_possible_before(failure: Failure, binding: FrameBinding, history: History) -> int | None:
    """A history rule: in some earlier state no check of the operator failed, and the history conditions held.

    Returns the number of the last such state, or None.
    """
    if history.before is None:
        return None
    conditions_hold = conjunction(failure.check.history_conditions)

    def is_possible(state: State) -> bool:
        return conditions_hold(state, binding) and find_failing_check(failure.checks, state, binding) is None

    return history.before.last_where((failure.check, failure.arguments), is_possible)
