"""The derived predicates of VirtualHome that need more than a formula: rooms, origins, full seats.

Of several objects all are found; an effect takes the first of them, that of the lowest index, that is, in the
order of the data set.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.world.state import State

Among: TypeAlias = Callable[[State, str, int, int], int]
"""Gives targets of a relation, given a state, the relation, the source and the targets wanted."""

Values: TypeAlias = Callable[[State, tuple[int, ...]], int]
"""Looks up the objects that make a predicate true as its last argument, as a mask."""

SEATS = {"couch": 4, "bed": 4, "sofa": 4, "loveseat": 2, "pianobench": 2, "bench": 2}
"""How many things fit on a seat, by class; 1 on any other (reference: ``SitExecutor``)."""

BEDS = {"bed": 3, "couch": 2, "bathtub": 2, "loveseat": 2, "sofa": 2}
"""How many things fit where one lies, by class; 1 on any other (reference: ``LieExecutor``)."""

PLACES = ("ONTOP", "INSIDE", "NEXT_TO")
"""The relations that say where an object was taken from, in the order in which they are asked."""


def object_id(state: State, index: int) -> int:
    """The id of an object in the data set: what follows the last dot of its name."""
    return int(state.scene.objects[index].name.rpartition(".")[2])


def rooms(state: State, arguments: tuple[int, ...]) -> int:
    """The rooms of an object, which may be in none: those that it is in, or those of its only container."""
    (x,) = arguments
    is_room, inside = state.those("ROOM"), state.relation("INSIDE")
    seen = 0
    while not (is_room | seen) >> x & 1:
        seen |= 1 << x
        containers = inside.row(x)
        if containers & is_room or containers & (containers - 1) or not containers:
            return containers & is_room
        x = containers.bit_length() - 1
    return 1 << x & is_room


def targets(state: State, predicate: str, source: int, wanted: int) -> int:
    """The targets of a relation among those wanted (a mask), as a mask."""
    return state.relation(predicate).row(source) & wanted


def origins(place: int, among: Among = targets) -> Values:
    """A lookup of what something lies on, in or next to, if ``PLACES[place]`` decides.

    Of several things those count that ``among`` gives. Rooms do not count. Only the first relation that holds
    at all decides, so at most one of the three lookups finds something (reference:
    ``_find_first_node_from``).
    """

    def lookup(state: State, arguments: tuple[int, ...]) -> int:
        (x,) = arguments
        no_room = ~state.those("ROOM")
        for earlier in PLACES[:place]:
            if state.relation(earlier).row(x) & no_room:
                return 0
        return among(state, PLACES[place], x, no_room)

    return lookup


def cargo(state: State, arguments: tuple[int, ...]) -> int:
    """All that goes where an object goes: what is in it, what can be grabbed and lies on it, and so on."""
    inside, ontop, loose = state.relation("INSIDE"), state.relation("ONTOP"), state.those("GRABBABLE")
    found, pending = 0, 1 << arguments[0]
    while pending:
        carrier = pending & -pending
        x = carrier.bit_length() - 1
        new = (inside.column(x) | ontop.column(x) & loose) & ~found
        found |= new
        pending = pending & ~carrier | new
    return found


def full_seat(state: State, arguments: tuple[int, ...]) -> bool:
    """Whether as many things as fit are on a seat."""
    return _count_on(state, arguments[0]) >= SEATS.get(state.scene.objects[arguments[0]].category, 1)


def full_bed(state: State, arguments: tuple[int, ...]) -> bool:
    """Whether as many things as fit are where one would lie."""
    return _count_on(state, arguments[0]) >= BEDS.get(state.scene.objects[arguments[0]].category, 1)


def _count_on(state: State, place: int) -> int:
    return state.relation("ONTOP").column(place).bit_count()
