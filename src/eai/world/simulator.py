"""Simulators: what an episode needs of a world, so that one of another make can carry its actions out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol, TypeAlias

if TYPE_CHECKING:
    from eai.world.execution import Action, Fault
    from eai.world.state import State


class Simulator(Protocol):
    """A world in which actions are carried out, begun anew for each episode.

    Its domain says what can be told of it and which actions are possible, and diagnoses those that are not:
    these never get here. Slips do not either. What plans are searched with, and exported, is the declaration.
    """

    @property
    def state(self) -> State:
        """The facts that hold now: a state of the same episode as that in which it began.

        `State.with_exactly` makes one of facts.
        """

    def act(self, action: Action, declared: State) -> State | Fault:
        """Carry out an action that is possible by its declaration.

        Args:
            action: the action.
            declared: the state that follows by the declared effects.

        Returns:
            The state after it, in which its intended effects hold; or why it failed, and then nothing has
            changed. The check of a fault need not be one of the declaration.
        """


Begin: TypeAlias = "Callable[[State], Simulator]"
"""Begins an episode in a state: equal states make equal worlds. It raises InputError where it cannot."""


class _Declared:
    """The world as it is declared: an action has the effects that its operator has."""

    def __init__(self, initial: State) -> None:
        self.state = initial

    def act(self, action: Action, declared: State) -> State | Fault:
        """Take the declared state."""
        self.state = declared
        return declared


def as_declared(initial: State) -> Simulator:
    """Begin an episode in which actions have their declared effects, and no others."""
    return _Declared(initial)
