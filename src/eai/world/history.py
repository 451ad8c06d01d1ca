"""Histories of states; and history rules, which test whether the fault of a step is a wrong order.

A failed check is a wrong order if its condition held in an earlier state. Trajectories with equal beginnings
share a history.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import partial
from typing import TypeAlias

from eai.world.condition import combine_tests_by_and
from eai.world.executable import CheckFailure, find_failing_check
from eai.world.fault import FaultKind
from eai.world.frame import ConditionTest, ObjectBySlot
from eai.world.state import State


class History:
    """A sequence of states: the last state, and the history of all states before it.

    Histories share their beginnings, so adding a state takes constant time. A history caches the answers of
    `find_last_state_index`. If a later history gets an equal question, only its new states are tested.

    Args:
        state: the last state.
        before: the history of the earlier states; None if ``state`` is the initial state.

    Attributes:
        state: the last state.
        before: the history of the earlier states, or None.
        number: number of earlier states.
    """

    __slots__ = ("_answers", "before", "number", "state")

    def __init__(self, state: State, before: History | None = None) -> None:
        self.state = state
        self.before = before
        self.number: int = 0 if before is None else before.number + 1
        self._answers: dict[Hashable, int | None] = {}

    def extend(self, state: State) -> History:
        """Return this history with one more state at its end."""
        return History(state, self)

    @property
    def states(self) -> tuple[State, ...]:
        """All states of the history, the initial state first."""
        states = []
        history: History | None = self
        while history is not None:
            states.append(history.state)
            history = history.before
        return tuple(reversed(states))

    def find_last_state_index(self, cache_key: Hashable, test: Callable[[State], bool]) -> int | None:
        """Return the index of the last state that passes a test, or None if no state passes.

        Args:
            cache_key: a key under which the answer is cached: equal keys must stand for equal tests.
            test: the test.
        """
        history: History | None = self
        number = None
        while history is not None:
            if cache_key in history._answers:
                number = history._answers[cache_key]
                break
            if test(history.state):
                number = history.number
                break
            history = history.before
        self._answers[cache_key] = number
        return number


HistoryRule: TypeAlias = Callable[[CheckFailure, ObjectBySlot, History], int | None]
"""Function that tests whether a check failed because of a wrong order of steps.

The order is wrong if the check's condition held in an earlier state. The function takes the failed check, the
binding of the action's variables, and the history: the initial state, then the state after each executed
step. It returns the index of the earlier state. None means that the condition never held: a step is missing.
"""


def find_when_conditions_held(failure: CheckFailure, binding: ObjectBySlot, history: History) -> int | None:
    """Return the index of the last state in which any history condition of a failed check held, or None.

    An index means that the order of actions is wrong, because every history condition held in some state. If
    any condition never held, or if the check's fault is not `MISSING_STEP`, return None.
    """
    if failure.check.check.fault is not FaultKind.MISSING_STEP:
        return None
    latest = 0
    for index, condition in enumerate(failure.check.history_conditions):
        question = (failure.check, index, failure.arguments)
        number = history.find_last_state_index(question, partial(_holds_in_state, condition, binding))
        if number is None:
            return None
        latest = max(latest, number)
    return latest


def _holds_in_state(truth: ConditionTest, binding: ObjectBySlot, state: State) -> bool:
    return truth(state, binding)


def find_when_action_was_possible(
    failure: CheckFailure, binding: ObjectBySlot, history: History
) -> int | None:
    """Return the index of the last earlier state in which an action was possible; None if it never was.

    In such a state, all checks of ``failure.checks`` pass, and the failed check's history conditions (its
    conditions on earlier states) hold. The function is a `HistoryRule`: an index means that the order of
    steps is wrong.
    """
    if history.before is None:
        return None
    conditions_hold = combine_tests_by_and(failure.check.history_conditions)

    def is_action_possible(state: State) -> bool:
        return conditions_hold(state, binding) and find_failing_check(failure.checks, state, binding) is None

    return history.before.find_last_state_index((failure.check, failure.arguments), is_action_possible)
