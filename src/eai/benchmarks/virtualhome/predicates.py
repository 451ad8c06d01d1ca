"""The predicates of a VirtualHome scene.

Names are those in the data set's temporal formulas. There, ``ON`` is the state of a device that runs. The
relations that scene graphs call ON and CLOSE are ``ONTOP`` and ``NEXT_TO``.

A function that looks up objects returns all matching objects as a bit mask. An effect uses only the first of
them, in the order of the data set: the object with the lowest index.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import eai.logic.formula as f
from eai.world.derived import ComputedPredicate, DefinedPredicate, LookupFunction, LookupPredicate, is_a
from eai.world.frame import AGENT
from eai.world.relation import ObjectMask, iterate_bits
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary

TargetChooser: TypeAlias = Callable[[State, str, int, ObjectMask], ObjectMask]
"""Function that chooses the targets of a relation, given a state, the relation, its source and candidates.

Targets and candidates are bit masks of objects.
"""

SEAT_CAPACITIES = {"couch": 4, "bed": 4, "sofa": 4, "loveseat": 2, "pianobench": 2, "bench": 2}
"""Class of a seat -> number of objects that fit; 1 otherwise (``SitExecutor`` of the paper's package)."""

BED_CAPACITIES = {"bed": 3, "couch": 2, "bathtub": 2, "loveseat": 2, "sofa": 2}
"""Class of a bed -> number of objects that fit; 1 otherwise (``LieExecutor`` of the paper's package)."""

RELATIONS_TO_PLACE_GRABBED_FROM = ("ONTOP", "INSIDE", "NEXT_TO")
"""Relations that define the origin (former place) of a grabbed object. Only the first that holds counts.
"""


def get_object_id(state: State, index: int) -> int:
    """Return the id of an object in the data set: the digits after the last dot of its name."""
    return int(state.scene.objects[index].name.rpartition(".")[2])


def find_rooms_containing_object(state: State, arguments: tuple[int, ...]) -> ObjectMask:
    """Return, as a bit mask, the rooms that contain an object; a room contains itself.

    An object in exactly one container, which is no room, is in the rooms of this container. The mask is 0 for
    no rooms.
    """
    (x,) = arguments
    is_room, inside = state.mask("ROOM"), state.relation("INSIDE")
    visited = 0
    while not (is_room | visited) >> x & 1:
        visited |= 1 << x
        containers = inside.row(x)
        if containers & is_room or containers & (containers - 1) or not containers:
            return containers & is_room
        x = containers.bit_length() - 1
    return 1 << x & is_room


def find_objects_in_room(state: State, arguments: tuple[int, ...]) -> ObjectMask:
    """Return a bit mask of the objects for which `find_rooms_containing_object` finds a given room."""
    (room,) = arguments
    is_room, inside = state.mask("ROOM"), state.relation("INSIDE")
    if not is_room >> room & 1:
        return 0
    members = inside.column(room) & ~is_room
    pending = members & inside.targets
    while pending:
        container = pending & -pending
        pending ^= container
        for y in iterate_bits(inside.column(container.bit_length() - 1) & ~is_room & ~members):
            if inside.row(y) == container:
                members |= 1 << y
                pending |= 1 << y & inside.targets
    return members | 1 << room


def find_related_candidates(state: State, predicate: str, source: int, candidates: ObjectMask) -> ObjectMask:
    """Return the candidates that are targets of a relation from the source.

    Candidates and result are bit masks.
    """
    return state.relation(predicate).row(source) & candidates


def make_lookup_of_places_to_grab_object_from(
    relation_index: int, choose: TargetChooser = find_related_candidates
) -> LookupFunction:
    """Return a lookup function for the origins of objects: the places from which they are grabbed.

    The function uses one relation of `RELATIONS_TO_PLACE_GRABBED_FROM`. If an earlier relation in this tuple
    relates the object to a place, the function returns no places. Rooms are never origins (as in
    ``_find_first_node_from`` of the paper's package).

    Args:
        relation_index: index of the relation in `RELATIONS_TO_PLACE_GRABBED_FROM`.
        choose: chooses among several places.
    """

    def find_places_object_is_grabbed_from(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        (x,) = arguments
        no_room = ~state.mask("ROOM")
        for earlier in RELATIONS_TO_PLACE_GRABBED_FROM[:relation_index]:
            if state.relation(earlier).row(x) & no_room:
                return 0
        return choose(state, RELATIONS_TO_PLACE_GRABBED_FROM[relation_index], x, no_room)

    return find_places_object_is_grabbed_from


def find_objects_carried_along(state: State, arguments: tuple[int, ...]) -> ObjectMask:
    """Return, as a bit mask, the objects that move with an object.

    An object moves if it is in a moving object, or if it is grabbable and on a moving object.
    """
    inside, ontop, loose = state.relation("INSIDE"), state.relation("ONTOP"), state.mask("GRABBABLE")
    carried, pending = 0, 1 << arguments[0]
    while pending:
        carrier = pending & -pending
        x = carrier.bit_length() - 1
        new = (inside.column(x) | ontop.column(x) & loose) & ~carried
        carried |= new
        pending = pending & ~carrier | new
    return carried


X = f.Variable("x")
Y = f.Variable("y")
Z = f.Variable("z")
R = f.Variable("r")

# Properties of objects state which actions an object allows. They never change.
body_part = Predicate("BODY_PART", 1, static=True)
can_open = Predicate("CAN_OPEN", 1, static=True)
clothes = Predicate("CLOTHES", 1, static=True)
containers = Predicate("CONTAINERS", 1, static=True)
cover_object = Predicate("COVER_OBJECT", 1, static=True)
cream = Predicate("CREAM", 1, static=True)
cuttable = Predicate("CUTTABLE", 1, static=True)
drinkable = Predicate("DRINKABLE", 1, static=True)
eatable = Predicate("EATABLE", 1, static=True)
grabbable = Predicate("GRABBABLE", 1, static=True)
hangable = Predicate("HANGABLE", 1, static=True)
has_paper = Predicate("HAS_PAPER", 1, static=True)
has_plug = Predicate("HAS_PLUG", 1, static=True)
has_switch = Predicate("HAS_SWITCH", 1, static=True)
lieable = Predicate("LIEABLE", 1, static=True)
lookable = Predicate("LOOKABLE", 1, static=True)
movable = Predicate("MOVABLE", 1, static=True)
person = Predicate("PERSON", 1, static=True)
pourable = Predicate("POURABLE", 1, static=True)
readable = Predicate("READABLE", 1, static=True)
recipient = Predicate("RECIPIENT", 1, static=True)
sittable = Predicate("SITTABLE", 1, static=True)
surfaces = Predicate("SURFACES", 1, static=True)

room = Predicate("ROOM", 1, static=True, visible=False)

# States of one object.
clean = Predicate("CLEAN", 1)
dirty = Predicate("DIRTY", 1)
closed = Predicate("CLOSED", 1)
open_ = Predicate("OPEN", 1)
on = Predicate("ON", 1)
off = Predicate("OFF", 1)
plugged_in = Predicate("PLUGGED_IN", 1)
plugged_out = Predicate("PLUGGED_OUT", 1)
sitting = Predicate("SITTING", 1)
lying = Predicate("LYING", 1)

# Relations between two objects.
ontop = Predicate("ONTOP", 2)
inside = Predicate("INSIDE", 2)
next_to = Predicate("NEXT_TO", 2)
facing = Predicate("FACING", 2)
holds_rh = Predicate("HOLDS_RH", 2)
holds_lh = Predicate("HOLDS_LH", 2)
between = Predicate("BETWEEN", 2, static=True)

# Predicates that relate a held object to the place from which it was grabbed.
taken_from_top_of = Predicate("TAKEN_FROM_TOP_OF", 2, visible=False, single=True)
taken_from_inside = Predicate("TAKEN_FROM_INSIDE", 2, visible=False, single=True)
taken_from_next_to = Predicate("TAKEN_FROM_NEXT_TO", 2, visible=False, single=True)

# Derived.
near = DefinedPredicate(
    "near", (X,), next_to(AGENT, X) | f.Exists(Y, next_to(AGENT, Y) & (next_to(Y, X) | ontop(X, Y)))
)
faced = DefinedPredicate("faced", (X,), facing(AGENT, X) | f.Exists(Y, facing(AGENT, Y) & facing(Y, X)))
SHUT_IN = f.Exists(Y, inside(X, Y) & ~room(Y) & closed(Y))
shut_in = DefinedPredicate("shut_in", (X,), SHUT_IN)
held = DefinedPredicate("held", (X,), holds_rh(AGENT, X) | holds_lh(AGENT, X))
right_hand_free = DefinedPredicate("right_hand_free", (), ~f.Exists(Y, holds_rh(AGENT, Y)))
left_hand_free = DefinedPredicate("left_hand_free", (), ~f.Exists(Y, holds_lh(AGENT, Y)))
hand_free = DefinedPredicate("hand_free", (), right_hand_free() | left_hand_free())
upright = DefinedPredicate("upright", (), ~sitting(AGENT) & ~lying(AGENT))
taken = DefinedPredicate(
    "taken", (X,), f.Exists(Y, taken_from_top_of(X, Y) | taken_from_inside(X, Y) | taken_from_next_to(X, Y))
)
rests_in = DefinedPredicate("rests_in", (X, Y), inside(X, Y) | (ontop(X, Y) & grabbable(X)))
carries = DefinedPredicate(
    "carries",
    (X, Y),
    rests_in(Y, X) | f.Exists(Z, rests_in(Z, X) & f.Atom("carries", (Z, Y))),
    find_objects_carried_along,
)
_only_container = inside(X, Y) & ~f.Exists(Z, inside(X, Z) & ~f.Equals(Y, Z))
room_of = LookupPredicate(
    "room_of",
    2,
    find_rooms_containing_object,
    reads=("ROOM", "INSIDE"),
    inverse=find_objects_in_room,
    meaning=DefinedPredicate(
        "room_of",
        (X, R),
        (room(X) & f.Equals(X, R))
        | (~room(X) & room(R) & inside(X, R))
        | (~room(X) & f.Exists(Y, _only_container & ~room(Y) & f.Atom("room_of", (Y, R)))),
    ),
)
in_same_room = DefinedPredicate("in_same_room", (X,), f.Exists(R, room_of(AGENT, R) & room_of(X, R)))
somewhere = DefinedPredicate("somewhere", (X,), f.Exists(R, room_of(X, R)))


def _make_predicate_of_place_to_grab_object_from(relation_index: int, name: str) -> LookupPredicate:
    """Return the predicate that relates an object to the places from which it is grabbed, by one relation.

    If an earlier relation in `RELATIONS_TO_PLACE_GRABBED_FROM` relates the object to a place, the predicate
    is false. Rooms are never such places.
    """
    *earlier, relation = (ontop, inside, next_to)[: relation_index + 1]
    nowhere_else = tuple(~f.Exists(Z, other(X, Z) & ~room(Z)) for other in earlier)
    meaning = DefinedPredicate(name, (X, Y), f.And((relation(X, Y), ~room(Y), *nowhere_else)))
    return LookupPredicate(
        name,
        2,
        make_lookup_of_places_to_grab_object_from(relation_index),
        ("ROOM", "ONTOP", "INSIDE", "NEXT_TO"),
        meaning,
    )


def _make_min_object_count_formula(support: f.Variable, min_count: int) -> f.Formula:
    """Return the formula that holds if at least `min_count` different objects are on the object `support`."""
    things = [f.Variable(f"y{i}") for i in range(min_count)]
    formula: f.Formula = f.And(())
    for i, obj in reversed(list(enumerate(things))):
        new = tuple(~f.Equals(obj, other) for other in things[:i])
        formula = f.Exists(obj, f.And((ontop(obj, support), *new, formula)))
    return formula


def _make_full_seat_predicate(name: str, capacities: Mapping[str, int]) -> ComputedPredicate:
    """Return the predicate that holds for a full seat or bed.

    Its capacity depends on its category, and is 1 for categories that `capacities` does not list.
    """

    def is_seat_full(state: State, arguments: tuple[int, ...]) -> bool:
        (seat,) = arguments
        capacity = capacities.get(state.scene.objects[seat].category, 1)
        return state.relation("ONTOP").column(seat).bit_count() >= capacity

    by_size = {n: [c for c, fits in capacities.items() if fits == n] for n in sorted({*capacities.values()})}
    sized = tuple(
        is_a(X, *categories) & _make_min_object_count_formula(X, n) for n, categories in by_size.items()
    )
    others = ~is_a(X, *capacities) & f.Exists(Y, ontop(Y, X))
    return ComputedPredicate(
        name, 1, is_seat_full, ("ONTOP",), DefinedPredicate(name, (X,), f.Or((*sized, others)))
    )


lies_on, lies_in, lies_next_to = (
    _make_predicate_of_place_to_grab_object_from(position, name)
    for position, name in enumerate(("lies_on", "lies_in", "lies_next_to"))
)
seat_full = _make_full_seat_predicate("seat_full", SEAT_CAPACITIES)
bed_full = _make_full_seat_predicate("bed_full", BED_CAPACITIES)

_DECLARED = tuple(globals().values())

VOCABULARY = Vocabulary(
    predicates=tuple([item for item in _DECLARED if isinstance(item, Predicate)]),
    derived=tuple(
        [
            item
            for item in _DECLARED
            if isinstance(item, DefinedPredicate | LookupPredicate | ComputedPredicate)
        ]
    ),
)
"""The predicates of this module, in order of declaration."""

PREDICATE_OF_RELATION = {
    "ON": "ONTOP",
    "INSIDE": "INSIDE",
    "CLOSE": "NEXT_TO",
    "FACING": "FACING",
    "BETWEEN": "BETWEEN",
    "HOLDS_RH": "HOLDS_RH",
    "HOLDS_LH": "HOLDS_LH",
}
"""Relation in scene graphs -> predicate of this module."""
