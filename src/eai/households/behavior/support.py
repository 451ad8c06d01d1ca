"""The derived predicates of BEHAVIOR that walk along supports: what carries an object, and where it is.

An object rests in or on at most one other, that one on the next, up to a root that rests on nothing. Where a
state that no action leads to has a circle of supports, it is walked once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.world.relation import Relation, bits
from eai.world.state import State

Values: TypeAlias = Callable[[State, tuple[int, ...]], int]
"""From an object to the mask of all that it stands in a relation to."""


def carriers(state: State, arguments: tuple[int, ...]) -> int:
    """Everything that an object rests in or on, directly or not, as a mask."""
    inside, ontop = state.relation("lies_in"), state.relation("lies_on")
    carriers = 0
    support = _support(inside, ontop, arguments[0])
    while support & ~carriers:
        carriers |= support
        support = _support(inside, ontop, support.bit_length() - 1)
    return carriers


def containers(state: State, arguments: tuple[int, ...]) -> int:
    """Everything that an object is in, or that something which carries it is in, as a mask."""
    inside, ontop = state.relation("lies_in"), state.relation("lies_on")
    (x,) = arguments
    containers = seen = 0
    while not seen >> x & 1:
        seen |= 1 << x
        container = inside.row(x)
        containers |= container
        support = container or ontop.row(x)
        if not support:
            break
        x = support.bit_length() - 1
    return containers


def targets(relation: str) -> Values:
    """All that an object stands in a stored relation to."""

    def values(state: State, arguments: tuple[int, ...]) -> int:
        return state.relation(relation).row(arguments[0])

    return values


def as_its_parts(values: Values) -> Values:
    """The relation as goals see it: an object that has been sliced is where both its parts are."""

    def seen(state: State, arguments: tuple[int, ...]) -> int:
        (x,) = arguments
        parts = state.relation("part_of").column(x) if state.those("is_sliced") >> x & 1 else 0
        if not parts:
            return values(state, arguments)
        common = state.scene.everything
        for part in bits(parts):
            common &= values(state, (part,))
        return common

    return seen


def standing_floor(state: State, arguments: tuple[int, ...]) -> int:
    """The floor that an object stands on, directly or with what carries it; a floor itself; or none."""
    (x,) = arguments
    floors, inside, ontop = state.those("floor"), state.relation("lies_in"), state.relation("lies_on")
    seen = 1 << x
    support = _support(inside, ontop, x)
    while support & ~seen and not floors >> x & 1:
        seen |= support
        x = support.bit_length() - 1
        support = _support(inside, ontop, x)
    return 1 << x if floors >> x & 1 else state.relation("stands_on").row(x)


def _support(inside: Relation, ontop: Relation, x: int) -> int:
    """What an object rests in or on, as a mask of at most one bit."""
    return inside.row(x) or ontop.row(x)
