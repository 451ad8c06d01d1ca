"""Translate steps of published planning operators to actions of a household domain."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeAlias

from eai.pddl.execute import PlanStep
from eai.world.action import Action

Counterpart: TypeAlias = tuple[str, tuple[int, ...]]
"""Household action for a planning operator, and positions of the operator's parameters that it takes."""


def translate_steps(
    steps: Iterable[PlanStep],
    counterparts: Mapping[str, Counterpart],
    index_of: Callable[[str], int | None],
) -> Iterator[Action]:
    """Yield the household action of each planning step, up to the first step whose operator has no action.

    Args:
        steps: the steps, each with as many objects as its operator has parameters.
        counterparts: planning operator -> household action.
        index_of: finds the index of a scene object by its name in planning problems.
    """
    for step in steps:
        counterpart = counterparts.get(step.action)
        if counterpart is None:
            return
        action, positions = counterpart
        indices = [index_of(step.arguments[position]) for position in positions]
        objects = tuple([index for index in indices if index is not None])
        if len(objects) < len(indices):
            return
        yield Action(action, objects)
