"""The derived predicates of BEHAVIOR that walk along supports: what carries an object, and where it stands.

An object rests in or on at most one other, that one on the next, up to a root that rests on nothing.
"""

from __future__ import annotations

from eai.world.relation import Relation
from eai.world.state import State


def carriers(state: State, arguments: tuple[int, ...]) -> int:
    """Everything that an object rests in or on, directly or not, as a mask."""
    inside, ontop = state.relation("lies_in"), state.relation("lies_on")
    carriers = 0
    support = _support(inside, ontop, arguments[0])
    while support:
        carriers |= support
        support = _support(inside, ontop, support.bit_length() - 1)
    return carriers


def shut_away(state: State, arguments: tuple[int, ...]) -> bool:
    """Whether an object, or something that carries it, is in something closed."""
    inside, ontop = state.relation("lies_in"), state.relation("lies_on")
    closed = state.those("openable") & ~state.those("is_open")
    (x,) = arguments
    while True:
        container = inside.row(x)
        if container & closed:
            return True
        support = container or ontop.row(x)
        if not support:
            return False
        x = support.bit_length() - 1


def standing_floor(state: State, arguments: tuple[int, ...]) -> int:
    """The floor that an object stands on, directly or with what carries it; a floor itself; or none."""
    (x,) = arguments
    if state.those("floor") >> x & 1:
        return 1 << x
    inside, ontop = state.relation("lies_in"), state.relation("lies_on")
    support = _support(inside, ontop, x)
    while support:
        x = support.bit_length() - 1
        support = _support(inside, ontop, x)
    return state.relation("stands_on").row(x)


def _support(inside: Relation, ontop: Relation, x: int) -> int:
    """What an object rests in or on, as a mask of at most one bit."""
    return inside.row(x) or ontop.row(x)
