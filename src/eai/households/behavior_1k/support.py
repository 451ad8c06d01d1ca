"""The derived predicates of BEHAVIOR-1K that walk along supports: what carries a thing, and where it is.

A thing rests in, on or at most one other, that one on the next, up to a root that rests on nothing.
"""

from __future__ import annotations

from eai.world.relation import Relation
from eai.world.state import State

INSIDE = "lies_in"
SUPPORTS = (INSIDE, "lies_on", "attached_to", "laid_over", "draped_on")
"""The stored relations to what a thing rests in or on."""


def carriers(state: State, arguments: tuple[int, ...]) -> int:
    """Everything that a thing rests in or on, directly or not, as a mask."""
    relations = [state.relation(name) for name in SUPPORTS]
    found, support = 0, _support(relations, arguments[0])
    while support & ~found:
        found |= support
        support = _support(relations, support.bit_length() - 1)
    return found


def containers(state: State, arguments: tuple[int, ...]) -> int:
    """Everything that a thing is in, or that something which carries it is in, as a mask."""
    relations = [state.relation(name) for name in SUPPORTS]
    (x,) = arguments
    found = seen = 0
    while not seen >> x & 1:
        seen |= 1 << x
        found |= relations[0].row(x)
        support = _support(relations, x)
        if not support:
            break
        x = support.bit_length() - 1
    return found


def floor_below(state: State, arguments: tuple[int, ...]) -> int:
    """The floor that a thing is on in the end: a floor itself, that below its root, or that of its room."""
    relations = [state.relation(name) for name in SUPPORTS]
    (x,) = arguments
    floors, seen = state.those("floor"), 0
    while not floors >> x & 1 and not seen >> x & 1:
        seen |= 1 << x
        support = _support(relations, x)
        if not support:
            held = state.those("held") >> x & 1
            return state.those("robot_on") if held else state.relation("by_floor").row(x)
        x = support.bit_length() - 1
    return 1 << x if floors >> x & 1 else 0


def _support(relations: list[Relation], x: int) -> int:
    """The support of a thing, as a mask of at most one bit."""
    for relation in relations:
        row = relation.row(x)
        if row:
            return row
    return 0
