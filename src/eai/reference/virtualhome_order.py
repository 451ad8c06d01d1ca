"""The first of several objects as eai-eval 1.0.5 takes it: by the order of a Python set (`slot_order`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from eai.households.virtualhome.places import PLACES, Values, object_id, origins
from eai.households.virtualhome.predicates import VOCABULARY
from eai.households.virtualhome.slot_order import slot_order, union_order
from eai.households.virtualhome.tasks import VirtualHomeTask
from eai.world.derived import Lookup
from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import DerivedPredicate, Vocabulary


def first_target(state: State, predicate: str, source: int, wanted: int) -> int:
    """The first target of a relation among those wanted (a mask), as a mask, empty if there is none."""
    found = state.relation(predicate).row(source) & wanted
    if found & (found - 1) == 0:
        return found
    return next(1 << y for y in _in_order(state, predicate, source) if found >> y & 1)


def _in_order(state: State, predicate: str, source: int) -> list[int]:
    """The targets of a relation, in the order of a set of ids.

    Those of edges added by actions were put into it first, then those of the initial scene. The latter are
    taken by ascending id, not in the order of the data set's file: the first target comes out the same for
    every object that a task can be about.
    """
    relation = state.relation(predicate)
    mask = relation.row(source)
    at_start = relation.base_row(source)
    by_id = {object_id(state, i): i for i in bits(mask | at_start)}
    added = sorted(object_id(state, i) for i in bits(mask & ~at_start))
    initial = sorted(object_id(state, i) for i in bits(at_start))
    return [by_id[i] for i in slot_order((*added, *initial)) if mask >> by_id[i] & 1]


def _room(state: State, arguments: tuple[int, ...]) -> int:
    """The one room of an object, which may be in none (reference: ``_get_room_node``).

    An object inside several things is in the first of them that is a room; otherwise the containers are
    followed upwards, of several the first.
    """
    (x,) = arguments
    is_room, inside = state.those("ROOM"), state.relation("INSIDE")
    if is_room >> x & 1:
        return 1 << x
    containers = inside.row(x)
    if containers & (containers - 1):
        return first_target(state, "INSIDE", x, is_room)
    seen = 0
    while containers and not containers & seen:
        if containers & (containers - 1):
            containers = first_target(state, "INSIDE", x, containers)
        if containers & is_room:
            return containers
        seen |= containers
        x = containers.bit_length() - 1
        containers = inside.row(x)
    return 0


_LOOKUPS: Mapping[str, Values] = {
    "room_of": _room,
    **{
        name: origins(place, first_target)
        for place, name in zip(range(len(PLACES)), ("lies_on", "lies_in", "lies_next_to"), strict=True)
    },
}


def _in_this_order(derived: DerivedPredicate) -> DerivedPredicate:
    lookup = _LOOKUPS.get(derived.name)
    if lookup is None or not isinstance(derived, Lookup):
        return derived
    return replace(derived, values=lookup, open_in_meaning="which of several objects is the first")


IN_SLOT_ORDER = Vocabulary(VOCABULARY.predicates, tuple(map(_in_this_order, VOCABULARY.derived)))
"""The vocabulary with these lookups: it stores the same, so that one state serves both."""


def relevant_objects(task: VirtualHomeTask) -> tuple[int, ...]:
    """The objects that a task is about, by index, as the reference finds them (``get_symbolic_goal_nl``)."""
    by_id = {object_id(task.initial, i): i for i in task.relevant}
    record = task.record
    return tuple([by_id[i] for i in union_order(record.relevant_from_nodes, record.relevant_from_edges)])
