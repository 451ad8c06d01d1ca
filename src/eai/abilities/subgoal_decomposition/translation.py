"""From subgoals to plans: what a benchmark may say of itself (`shortest_plans` is what is done otherwise)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TypeAlias

from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.task import Task
from eai.planning.subgoal import GroundAtom
from eai.world.execution import Action
from eai.world.state import Scene, State

Plans: TypeAlias = Callable[[State], Sequence[Plan]]
"""The plans for a subgoal in a state, each to be tried; none if nothing is to be done there."""


class Translation(ABC):
    """Says what is done for subgoals.

    Attributes:
        whole: whether the literals of a conjunction are brought about together, and tested when that is done;
            otherwise plans are made for one after the other, and trusted.
    """

    whole: bool = False

    @abstractmethod
    def brings_about(self, literal: GroundAtom, scene: Scene) -> bool:
        """Whether anything is done for a literal; if not, it must hold by itself."""

    def are_done_together(self, first: GroundAtom, second: GroundAtom) -> bool:
        """Whether two literals that follow each other are brought about at once, wherever one stands."""
        return False

    @abstractmethod
    def plans(self, literals: Sequence[GroundAtom], task: Task) -> Plans:
        """The plans for literals that shall hold: one, two that are done together, or a whole conjunction."""

    def plans_to_take(self, action: Action, task: Task) -> Plans:
        """The plans that take an action; by default nothing but the action."""
        return lambda state: ((action,),)
