"""Derived predicates that walk along supports: what carries a thing, what it is in, and on which floor.

A thing rests in, on or at most one other, that one on the next, up to a root that rests on nothing. Where a
state that no action leads to has a circle of supports, it is walked once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from eai.world.derived import Values
from eai.world.state import State


class _Walk(NamedTuple):
    """All that a thing rests in or on, as a mask, those of it in which it is, and the root of all."""

    carriers: int
    containers: int
    root: int


def _walk(state: State, supports: Sequence[str], thing: int) -> _Walk:
    relations = [state.relation(name) for name in supports]
    carriers = containers = 0
    while True:
        for relation in relations:
            row = relation.row(thing)
            if row:
                break
        if not row or row & carriers:
            return _Walk(carriers, containers, thing)
        carriers |= row
        if relation is relations[0]:
            containers |= row
        thing = row.bit_length() - 1


def carriers(supports: Sequence[str]) -> Values:
    """Everything that a thing rests in or on, directly or not, by these stored relations."""
    return lambda state, arguments: _walk(state, supports, arguments[0]).carriers


def containers(supports: Sequence[str]) -> Values:
    """Everything that a thing, or something which carries it, is in: the first of these relations."""
    return lambda state, arguments: _walk(state, supports, arguments[0]).containers


def floors(supports: Sequence[str], of_root: Callable[[State, int], int]) -> Values:
    """The floor that a thing is on in the end: the root itself if it is one, or else that of the root."""

    def values(state: State, arguments: tuple[int, ...]) -> int:
        root = _walk(state, supports, arguments[0]).root
        return 1 << root if state.those("floor") >> root & 1 else of_root(state, root)

    return values
