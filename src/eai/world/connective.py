"""What connectives and quantifiers do: truths and extensions made of other ones.

A connective is a function called millions of times. That of two operands, by far the most frequent, has a
form of its own, and so has an emptiness that asks for a stored mask.
"""

from __future__ import annotations

from collections.abc import Sequence

from eai.world.frame import Binding, Extension, Truth
from eai.world.state import State


def all_of(parts: Sequence[Truth]) -> Truth:
    """Whether every part holds; they are asked in order."""
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) and second(state, binding)

    def truth(state: State, binding: Binding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as all() over a generator
            if not part(state, binding):
                return False
        return True

    return truth


def any_of(parts: Sequence[Truth]) -> Truth:
    """Whether some part holds; they are asked in order."""
    if len(parts) == 2:
        first, second = parts
        return lambda state, binding: first(state, binding) or second(state, binding)

    def truth(state: State, binding: Binding) -> bool:
        for part in parts:  # noqa: SIM110 - a loop is three times as fast as any() over a generator
            if part(state, binding):
                return True
        return False

    return truth


def intersection(inside: Sequence[Extension], outside: Sequence[Extension]) -> Extension:
    """The objects in all of the one masks and in none of the others."""
    if len(inside) == 2 and not outside:
        first, second = inside
        return lambda state, binding: (mask := first(state, binding)) and mask & second(state, binding)
    if len(inside) == 1 and len(outside) == 1:
        (included,), (excluded,) = inside, outside
        return lambda state, binding: (mask := included(state, binding)) and mask & ~excluded(state, binding)

    def extension(state: State, binding: Binding) -> int:
        mask = state.scene.everything
        for part in inside:
            mask &= part(state, binding)
        for part in outside:
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


def emptiness(matching: Extension, *, wanted: bool) -> Truth:
    """Whether no object is in the mask, or (not ``wanted``) some object is."""
    if wanted:
        return lambda state, binding: not matching(state, binding)
    return lambda state, binding: matching(state, binding) != 0


def negation(part: Truth) -> Truth:
    """Whether the part does not hold."""
    return lambda state, binding: not part(state, binding)
