"""Translate steps of published planning operators to household actions (their counterparts)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeAlias

from eai.pddl.execute import PlanStep
from eai.world.action import Action

Counterpart: TypeAlias = tuple[str, tuple[int, ...]]
"""The household action of a planning operator, and which parameters become its objects."""


def translate_steps(
    steps: Iterable[PlanStep],
    counterparts: Mapping[str, Counterpart],
    index_of: Callable[[str], int | None],
) -> Iterator[Action]:
    """Yield the household action of each planning step, up to the first step without one.

    Args:
        steps: the steps, with as many objects as their operators have parameters.
        counterparts: actions by operator.
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
