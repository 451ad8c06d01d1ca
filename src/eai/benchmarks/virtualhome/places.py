"""The derived predicates of VirtualHome that need more than a formula: rooms, origins, full seats.

Where the reference takes "the first" of several objects, it means the first in the iteration order of a
Python set of ids (spec section c, "id-set order"). `slot_order` reproduces that order; both protocols use it.
"""

from __future__ import annotations

from collections.abc import Callable

from eai.benchmarks.reference.slot_order import slot_order
from eai.world.relation import bits
from eai.world.state import State

SEATS = {"couch": 4, "bed": 4, "sofa": 4, "loveseat": 2, "pianobench": 2, "bench": 2}
"""How many things fit on a seat, by class; 1 on any other (reference: ``SitExecutor``)."""

BEDS = {"bed": 3, "couch": 2, "bathtub": 2, "loveseat": 2, "sofa": 2}
"""How many things fit where one lies, by class; 1 on any other (reference: ``LieExecutor``)."""

PLACES = ("ONTOP", "INSIDE", "NEXT_TO")
"""The relations that say where an object was taken from, in the order in which they are asked."""


def object_id(state: State, index: int) -> int:
    """The id of an object in the data set: what follows the last dot of its name."""
    return int(state.scene.objects[index].name.rpartition(".")[2])


def first_target(state: State, predicate: str, source: int, wanted: int) -> int:
    """The first target of a relation among those wanted (a mask), as a mask, empty if there is none."""
    found = state.relation(predicate).row(source) & wanted
    if found & (found - 1) == 0:
        return found
    return next(1 << y for y in _in_order(state, predicate, source) if found >> y & 1)


def _in_order(state: State, predicate: str, source: int) -> list[int]:
    """The targets of a relation, in the reference's order.

    That is the order of a set of ids, into which those of edges added by actions are put first, then those of
    the initial scene. The latter are taken by ascending id, not in the order of the data set's file: the
    first target comes out the same for every object that a task can be about.
    """
    relation = state.relation(predicate)
    mask = relation.row(source)
    at_start = relation.base_row(source)
    by_id = {object_id(state, i): i for i in bits(mask | at_start)}
    added = sorted(object_id(state, i) for i in bits(mask & ~at_start))
    initial = sorted(object_id(state, i) for i in bits(at_start))
    return [by_id[i] for i in slot_order((*added, *initial)) if mask >> by_id[i] & 1]


def rooms(state: State, arguments: tuple[int, ...]) -> int:
    """The room of an object, as a mask that is empty if there is none (reference: ``_get_room_node``).

    An object inside several things is in the first of them that is a room; otherwise the containers are
    followed upwards.
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


def origins(place: int) -> Callable[[State, tuple[int, ...]], int]:
    """A lookup of the first object that something lies on, in or next to, if ``PLACES[place]`` decides.

    Rooms do not count. Only the first relation that holds at all decides, so at most one of the three lookups
    finds something (reference: ``_find_first_node_from``).
    """

    def lookup(state: State, arguments: tuple[int, ...]) -> int:
        (x,) = arguments
        no_room = ~state.those("ROOM")
        for earlier in PLACES[:place]:
            if state.relation(earlier).row(x) & no_room:
                return 0
        return first_target(state, PLACES[place], x, no_room)

    return lookup


def full_seat(state: State, arguments: tuple[int, ...]) -> bool:
    """Whether as many things as fit are on a seat."""
    return _count_on(state, arguments[0]) >= SEATS.get(state.scene.objects[arguments[0]].category, 1)


def full_bed(state: State, arguments: tuple[int, ...]) -> bool:
    """Whether as many things as fit are where one would lie."""
    return _count_on(state, arguments[0]) >= BEDS.get(state.scene.objects[arguments[0]].category, 1)


def _count_on(state: State, place: int) -> int:
    return state.relation("ONTOP").column(place).bit_count()
