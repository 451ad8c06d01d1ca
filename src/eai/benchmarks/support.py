"""Derived predicates that walk along supports: what carries a thing, what it is in, and on which floor.

A thing rests in, on or at most one other, that one on the next, up to a root that rests on nothing. Where a
state that no action leads to has a circle of supports, it is walked once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import or_

import eai.logic.formula as f
from eai.world.derived import Defined, LookupFunction
from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import Predicate

X, Y, Z = f.Variable("x"), f.Variable("y"), f.Variable("z")


def _chain(state: State, supports: Sequence[str], thing: int) -> Mapping[int, bool]:
    """Return all supports of a thing, each as a mask, its own first, and whether the first relation holds."""
    binary, slots = state.binary, state.scene.vocabulary.binary_slots
    chain: dict[int, bool] = {}
    while True:
        for name in supports:
            relation = binary[slots[name]]
            if relation.sources >> thing & 1 and (support := relation.row(thing)):
                break
        else:
            return chain
        if support in chain:
            return chain
        chain[support] = name == supports[0]
        thing = support.bit_length() - 1


def carrying(supports: Sequence[Predicate]) -> tuple[Defined, Defined, Defined]:
    """Return, by these relations, what carries a thing, what it is carried by at all, what it is within."""
    names = [relation.name for relation in supports]

    def carriers(state: State, arguments: tuple[int, ...]) -> int:
        """Everything that a thing rests in or on, directly or not."""
        return reduce(or_, _chain(state, names, arguments[0]), 0)

    def containers(state: State, arguments: tuple[int, ...]) -> int:
        """Everything that a thing, or something which carries it, is in: the first of these relations."""
        chain = _chain(state, names, arguments[0])
        return reduce(or_, [support for support, is_in in chain.items() if is_in], 0)

    carries = Defined("carries", (X, Y), f.Or(tuple([relation(Y, X) for relation in supports])))
    above, within = [f.Exists(Z, carries(Z, X) & f.Atom(name, (Z, Y))) for name in ("carried_by", "within")]
    return (
        carries,
        Defined("carried_by", (X, Y), carries(Y, X) | above, carriers),
        Defined("within", (X, Y), supports[0](X, Y) | within, containers),
    )


def on_floor(name: str, floor: Predicate, carries: Defined, of_root: f.Formula) -> Defined:
    """The floor that a thing is on, by name: itself, or that of what carries it, or that of the root."""
    carried = f.Exists(Z, carries(Z, X))
    above = f.Exists(Z, carries(Z, X) & f.Atom(name, (Z, Y)))
    definition = (floor(X) & f.Equals(X, Y)) | (~floor(X) & ~carried & of_root) | (~floor(X) & above)
    return Defined(name, (X, Y), definition)


def floors(supports: Sequence[str], of_root: Callable[[State, int], int]) -> LookupFunction:
    """The floor that a thing is on: itself, the first on the way to the root, or that of the root."""

    def values(state: State, arguments: tuple[int, ...]) -> int:
        (root,) = arguments
        floors = state.mask("floor")
        for support in (1 << root, *_chain(state, supports, root)):
            if support & floors:
                return support
            root = support.bit_length() - 1
        return of_root(state, root)

    return values


def inverse(values: LookupFunction) -> LookupFunction:
    """All things that have an object among their values, kept for one state: a search asks of it often."""
    kept: tuple[State | None, Mapping[int, int]] = None, {}

    def sources(state: State, arguments: tuple[int, ...]) -> int:
        nonlocal kept
        of, found = kept
        if of is not state:
            found = _inverted(values, state)
            kept = state, found
        return found.get(arguments[0], 0)

    return sources


def _inverted(values: LookupFunction, state: State) -> Mapping[int, int]:
    """For each object the mask of those that have it among their values."""
    found: dict[int, int] = {}
    for thing in bits(state.scene.everything):
        for value in bits(values(state, (thing,))):
            found[value] = found.get(value, 0) | 1 << thing
    return found
