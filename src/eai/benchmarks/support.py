"""Derive, from relations of support, an object's contents, the objects that carry it, and its floor.

An object rests in or on at most one other object, its support. The support may rest on another object, and so
on up to an object without support, the root. No action creates a cycle of supports. A cycle is
followed only once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from operator import or_

import eai.logic.formula as f
from eai.world.derived import DefinedPredicate, LookupFunction
from eai.world.relation import ObjectMask, iterate_bits
from eai.world.state import State
from eai.world.vocabulary import Predicate

X, Y, Z = f.Variable("x"), f.Variable("y"), f.Variable("z")


def _map_support_masks_to_container_flags(
    state: State, support_relations: Sequence[str], obj: int
) -> Mapping[ObjectMask, bool]:
    """Return the direct and indirect supports of an object, each with whether it is a container.

    The keys are the supports, as bit masks of objects; the nearest support comes first. The first of
    `support_relations` states containment: it relates an object to a support that is a container.
    """
    binary, slots = state.binary, state.scene.vocabulary.binary_slots
    chain: dict[ObjectMask, bool] = {}
    while True:
        for name in support_relations:
            relation = binary[slots[name]]
            if relation.sources >> obj & 1 and (support := relation.row(obj)):
                break
        else:
            return chain
        if support in chain:
            return chain
        chain[support] = name == support_relations[0]
        obj = support.bit_length() - 1


def make_predicates_carries_carried_by_within(
    support_relations: Sequence[Predicate],
) -> tuple[DefinedPredicate, DefinedPredicate, DefinedPredicate]:
    """Return the predicates ``carries``, ``carried_by`` and ``within``.

    - ``carries`` relates a support to the objects directly in or on it.
    - ``carried_by`` relates an object to its direct and indirect supports.
    - ``within`` relates an object to its containers and to the containers of its supports.

    The first of `support_relations` is the relation of containment.
    """
    names = [relation.name for relation in support_relations]

    def find_direct_and_indirect_supports(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        """Return all direct and indirect supports of an object, as a bit mask."""
        return reduce(or_, _map_support_masks_to_container_flags(state, names, arguments[0]), 0)

    def find_direct_and_indirect_containers(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        """Return, as a bit mask, all containers of an object and of its direct and indirect supports."""
        containers = 0
        for support, is_in in _map_support_masks_to_container_flags(state, names, arguments[0]).items():
            if is_in:
                containers |= support
        return containers

    carries = DefinedPredicate(
        "carries", (X, Y), f.Or(tuple([relation(Y, X) for relation in support_relations]))
    )
    above, within = [f.Exists(Z, carries(Z, X) & f.Atom(name, (Z, Y))) for name in ("carried_by", "within")]
    return (
        carries,
        DefinedPredicate("carried_by", (X, Y), carries(Y, X) | above, find_direct_and_indirect_supports),
        DefinedPredicate(
            "within", (X, Y), support_relations[0](X, Y) | within, find_direct_and_indirect_containers
        ),
    )


def make_predicate_for_floor_of_object(
    name: str, is_floor: Predicate, is_support_of: DefinedPredicate, floor_of_unsupported_object: f.Formula
) -> DefinedPredicate:
    """Return the predicate that relates an object to its floor.

    A floor is its own floor. An object with a support has the floor of its support. For an object without
    support, the formula ``floor_of_unsupported_object`` states the floor.
    """
    carried = f.Exists(Z, is_support_of(Z, X))
    above = f.Exists(Z, is_support_of(Z, X) & f.Atom(name, (Z, Y)))
    definition = (
        (is_floor(X) & f.Equals(X, Y))
        | (~is_floor(X) & ~carried & floor_of_unsupported_object)
        | (~is_floor(X) & above)
    )
    return DefinedPredicate(name, (X, Y), definition)


def make_lookup_of_floor_under_object(
    support_relations: Sequence[str], find_floor_of_unsupported: Callable[[State, int], ObjectMask]
) -> LookupFunction:
    """Return a function that finds an object's floor, as a bit mask.

    The floor is the first floor among the object and its direct and indirect supports. If these include no
    floor, `find_floor_of_unsupported` finds the floor under the lowest support, or under an unsupported
    object.
    """

    def find_floor_under_object(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        (root,) = arguments
        floors = state.mask("floor")
        for support in (1 << root, *_map_support_masks_to_container_flags(state, support_relations, root)):
            if support & floors:
                return support
            root = support.bit_length() - 1
        return find_floor_of_unsupported(state, root)

    return find_floor_under_object


def make_cached_inverse_of_lookup_function(lookup: LookupFunction) -> LookupFunction:
    """Return the inverse of a function that, in a state, maps an object to other objects.

    The inverse is cached for one state, because a search often calls it for the same state.
    """
    cached: tuple[State | None, Mapping[int, ObjectMask]] = None, {}

    def evaluate_inverse_lookup(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        nonlocal cached
        cached_state, by_value = cached
        if cached_state is not state:
            by_value = _map_lookup_results_to_their_arguments(lookup, state)
            cached = state, by_value
        return by_value.get(arguments[0], 0)

    return evaluate_inverse_lookup


def _map_lookup_results_to_their_arguments(lookup: LookupFunction, state: State) -> Mapping[int, ObjectMask]:
    """Return a mapping: object -> bit mask of the objects for which a lookup returns this object."""
    sources: dict[int, ObjectMask] = {}
    for obj in iterate_bits(state.scene.everything):
        for value in iterate_bits(lookup(state, (obj,))):
            sources[value] = sources.get(value, 0) | 1 << obj
    return sources
