"""The past of a trajectory: its states so far, shared by all trajectories that begin with them."""

from __future__ import annotations

from collections.abc import Callable, Hashable

from eai.world.state import State


class Past:
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

    def __init__(self, state: State, before: Past | None = None) -> None:
        self.state = state
        self.before = before
        self.number: int = 0 if before is None else before.number + 1
        self._latest: dict[Hashable, int | None] | None = None

    def then(self, state: State) -> Past:
        """The past after one more state."""
        return Past(state, self)

    @property
    def states(self) -> tuple[State, ...]:
        """All states, from the initial one on."""
        found = []
        moment: Past | None = self
        while moment is not None:
            found.append(moment.state)
            moment = moment.before
        return tuple(reversed(found))

    def latest(self, question: Hashable, test: Callable[[State], bool]) -> int | None:
        """The number of the latest state that passes a test, or None.

        Args:
            question: stands for the test: where it is the same, so is what the test says of any state.
            test: looks at a state.
        """
        moment: Past | None = self
        found = None
        while moment is not None:
            if moment._latest is not None and question in moment._latest:
                found = moment._latest[question]
                break
            if test(moment.state):
                found = moment.number
                break
            moment = moment.before
        if self._latest is None:
            self._latest = {}
        self._latest[question] = found
        return found
