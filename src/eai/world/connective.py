"""What connectives and quantifiers do: truths and extensions made of other ones.

A connective is a function called millions of times. That of two operands, by far the most frequent, has a
form of its own, and so has an emptiness that asks for a stored mask.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from eai.world.frame import Binding, Extension, Truth
from eai.world.state import State


class Literal(NamedTuple):
    """That the object in a slot of the binding has a stored unary predicate (``bit`` 1), or has not (0)."""

    predicate: int
    argument: int
    bit: int


def all_of(literals: Sequence[Literal], parts: Sequence[Truth]) -> Truth:
    """Whether every literal and every part holds; the parts are asked last, in order."""
    if not literals and len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) and second(state, binding)
    table = [(each.predicate, each.argument, each.bit) for each in literals]  # plain tuples unpack faster

    def truth(state: State, binding: Binding) -> bool:
        unary = state.unary
        for predicate, argument, bit in table:
            if unary[predicate] >> binding[argument] & 1 != bit:
                return False
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as all() over a generator
            if not part(state, binding):
                return False
        return True

    return truth


def any_of(literals: Sequence[Literal], parts: Sequence[Truth]) -> Truth:
    """Whether some literal or some part holds; the parts are asked last, in order."""
    table = [(each.predicate, each.argument, each.bit) for each in literals]

    def truth(state: State, binding: Binding) -> bool:
        unary = state.unary
        for predicate, argument, bit in table:
            if unary[predicate] >> binding[argument] & 1 == bit:
                return True
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as any() over a generator
            if part(state, binding):
                return True
        return False

    return truth


def intersection(
    having: Sequence[int], lacking: Sequence[int], inside: Sequence[Extension], outside: Sequence[Extension]
) -> Extension:
    """The objects with some stored unary predicates and without others, in some masks and not in others."""
    if len(inside) == 2 and not (having or lacking or outside):
        first, second = inside
        return lambda state, binding: (mask := first(state, binding)) and mask & second(state, binding)

    if len(having) == len(inside) == 1 and not (lacking or outside):
        (stored,), (among,) = having, inside
        return lambda state, binding: (mask := state.unary[stored]) and mask & among(state, binding)

    def extension(state: State, binding: Binding) -> int:
        mask, unary = state.scene.everything, state.unary
        for predicate in having:
            mask &= unary[predicate]
        for predicate in lacking:
            mask &= ~unary[predicate]
        for part in inside:
            if not mask:
                return 0
            mask &= part(state, binding)
        for part in outside:
            if not mask:
                return 0
            mask &= ~part(state, binding)
        return mask

    return extension


def union(parts: Sequence[Extension]) -> Extension:
    """The objects in any of the masks."""
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) | second(state, binding)

    def extension(state: State, binding: Binding) -> int:
        mask = 0
        for part in parts:
            mask |= part(state, binding)
        return mask

    return extension


def emptiness(matching: Extension | int, *, wanted: bool) -> Truth:
    """Whether no object is in a mask, or (not ``wanted``) some object is.

    Args:
        matching: the mask, or the slot of the stored unary predicate whose mask is meant.
        wanted: which of the two is asked.
    """
    if isinstance(matching, int):
        predicate = matching
        return lambda state, binding: (state.unary[predicate] == 0) is wanted
    if wanted:
        return lambda state, binding: not matching(state, binding)
    return lambda state, binding: matching(state, binding) != 0


def negation(part: Truth) -> Truth:
    """Whether the part does not hold."""
    return lambda state, binding: not part(state, binding)
