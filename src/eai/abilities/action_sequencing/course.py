"""The course that a plan takes: what became of it in a world that may have a past, and may fail it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

from eai.world.execution import Action, Trajectory


class Course(NamedTuple):
    """What became of a plan that was carried out.

    Attributes:
        trajectory: of this plan alone, from the state in which it began.
        before: the actions that were executed earlier in the same world, by name.
        slipped: whether a slip ended it.
        whole: all that has happened in this world, where it did not begin with this plan.
    """

    trajectory: Trajectory
    before: tuple[str, ...] = ()
    slipped: bool = False
    whole: Trajectory | None = None

    @property
    def taken(self) -> list[str]:
        """All actions that were executed in this world, by name."""
        return [*self.before, *[action.operator for action in self.trajectory.executed]]


CarryOut: TypeAlias = Callable[[tuple[Action, ...]], Course]
"""How plans are carried out; one of no steps begins and ends where the world is."""
