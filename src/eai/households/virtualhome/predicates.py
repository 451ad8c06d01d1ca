"""The predicates of a VirtualHome scene.

Names are those of the data set's temporal formulas: ``ON`` is the state of a device, ``ONTOP`` the relation
that scene graphs call ON, ``NEXT_TO`` the one that they call CLOSE.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import eai.logic.formula as f
from eai.households.virtualhome.places import BEDS, SEATS, cargo, full_bed, full_seat, origins, rooms
from eai.world.derived import Computed, Defined, Lookup, is_a
from eai.world.frame import AGENT
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary

X = f.Variable("x")
Y = f.Variable("y")
Z = f.Variable("z")
R = f.Variable("r")

# Properties: what an object is good for. They never change.
PROPERTIES = (
    "BODY_PART",
    "CAN_OPEN",
    "CLOTHES",
    "CONTAINERS",
    "COVER_OBJECT",
    "CREAM",
    "CUTTABLE",
    "DRINKABLE",
    "EATABLE",
    "GRABBABLE",
    "HANGABLE",
    "HAS_PAPER",
    "HAS_PLUG",
    "HAS_SWITCH",
    "LIEABLE",
    "LOOKABLE",
    "MOVABLE",
    "PERSON",
    "POURABLE",
    "READABLE",
    "RECIPIENT",
    "SITTABLE",
    "SURFACES",
)
_properties = tuple(Predicate(name, 1, static=True) for name in PROPERTIES)
_property = {predicate.name: predicate for predicate in _properties}
body_part = _property["BODY_PART"]
can_open = _property["CAN_OPEN"]
clothes = _property["CLOTHES"]
cuttable = _property["CUTTABLE"]
drinkable = _property["DRINKABLE"]
eatable = _property["EATABLE"]
grabbable = _property["GRABBABLE"]
has_plug = _property["HAS_PLUG"]
has_switch = _property["HAS_SWITCH"]
lieable = _property["LIEABLE"]
lookable = _property["LOOKABLE"]
movable = _property["MOVABLE"]
person = _property["PERSON"]
pourable = _property["POURABLE"]
readable = _property["READABLE"]
recipient = _property["RECIPIENT"]
sittable = _property["SITTABLE"]

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

# Relations of two objects.
ontop = Predicate("ONTOP", 2)
inside = Predicate("INSIDE", 2)
next_to = Predicate("NEXT_TO", 2)
facing = Predicate("FACING", 2)
holds_rh = Predicate("HOLDS_RH", 2)
holds_lh = Predicate("HOLDS_LH", 2)
between = Predicate("BETWEEN", 2, static=True)

# Memory of where an object in the hand was taken from.
taken_from_top_of = Predicate("TAKEN_FROM_TOP_OF", 2, visible=False, single=True)
taken_from_inside = Predicate("TAKEN_FROM_INSIDE", 2, visible=False, single=True)
taken_from_next_to = Predicate("TAKEN_FROM_NEXT_TO", 2, visible=False, single=True)

# Derived.
near = Defined(
    "near",
    (X,),
    next_to(AGENT, X) | f.Exists(Y, next_to(AGENT, Y) & (next_to(Y, X) | ontop(X, Y))),
)
faced = Defined("faced", (X,), facing(AGENT, X) | f.Exists(Y, facing(AGENT, Y) & facing(Y, X)))
SHUT_IN = f.Exists(Y, inside(X, Y) & ~room(Y) & closed(Y))
shut_in = Defined("shut_in", (X,), SHUT_IN)
held = Defined("held", (X,), holds_rh(AGENT, X) | holds_lh(AGENT, X))
right_hand_free = Defined("right_hand_free", (), ~f.Exists(Y, holds_rh(AGENT, Y)))
left_hand_free = Defined("left_hand_free", (), ~f.Exists(Y, holds_lh(AGENT, Y)))
hand_free = Defined("hand_free", (), right_hand_free() | left_hand_free())
upright = Defined("upright", (), ~sitting(AGENT) & ~lying(AGENT))
taken = Defined(
    "taken",
    (X,),
    f.Exists(Y, taken_from_top_of(X, Y) | taken_from_inside(X, Y) | taken_from_next_to(X, Y)),
)
rests_in = Defined("rests_in", (X, Y), inside(X, Y) | (ontop(X, Y) & grabbable(X)))
carries = Defined(
    "carries",
    (X, Y),
    rests_in(Y, X) | f.Exists(Z, rests_in(Z, X) & f.Atom("carries", (Z, Y))),
    cargo,
)
_only_container = inside(X, Y) & ~f.Exists(Z, inside(X, Z) & ~f.Equals(Y, Z))
room_of = Lookup(
    "room_of",
    2,
    rooms,
    reads=("ROOM", "INSIDE"),
    meaning=Defined(
        "room_of",
        (X, R),
        (room(X) & f.Equals(X, R))
        | (~room(X) & room(R) & inside(X, R))
        | (~room(X) & f.Exists(Y, _only_container & ~room(Y) & f.Atom("room_of", (Y, R)))),
    ),
)
in_same_room = Defined("in_same_room", (X,), f.Exists(R, room_of(AGENT, R) & room_of(X, R)))
somewhere = Defined("somewhere", (X,), f.Exists(R, room_of(X, R)))


def _lies(place: int, name: str) -> Lookup:
    """What something lies on, in or next to, by one relation if none before it holds."""
    *earlier, relation = (ontop, inside, next_to)[: place + 1]
    nowhere_else = tuple(~f.Exists(Z, other(X, Z) & ~room(Z)) for other in earlier)
    meaning = Defined(name, (X, Y), f.And((relation(X, Y), ~room(Y), *nowhere_else)))
    return Lookup(name, 2, origins(place), ("ROOM", "ONTOP", "INSIDE", "NEXT_TO"), meaning)


def _so_many_on(place: f.Variable, count: int) -> f.Formula:
    """So many different things, or more, are on a place."""
    things = [f.Variable(f"y{i}") for i in range(count)]
    found: f.Formula = f.And(())
    for i, thing in reversed(list(enumerate(things))):
        new = tuple(~f.Equals(thing, other) for other in things[:i])
        found = f.Exists(thing, f.And((ontop(thing, place), *new, found)))
    return found


def _full(
    name: str, capacities: Mapping[str, int], test: Callable[[State, tuple[int, ...]], bool]
) -> Computed:
    """As many things are on a place as fit there, by its category; 1 where nothing is said."""
    by_size = {n: [c for c, fits in capacities.items() if fits == n] for n in sorted({*capacities.values()})}
    sized = tuple(is_a(X, *categories) & _so_many_on(X, n) for n, categories in by_size.items())
    others = ~is_a(X, *capacities) & f.Exists(Y, ontop(Y, X))
    return Computed(name, 1, test, ("ONTOP",), Defined(name, (X,), f.Or((*sized, others))))


lies_on, lies_in, lies_next_to = (
    _lies(place, name) for place, name in enumerate(("lies_on", "lies_in", "lies_next_to"))
)
seat_full = _full("seat_full", SEATS, full_seat)
bed_full = _full("bed_full", BEDS, full_bed)

VOCABULARY = Vocabulary(
    predicates=(
        *_properties,
        room,
        clean,
        dirty,
        closed,
        open_,
        on,
        off,
        plugged_in,
        plugged_out,
        sitting,
        lying,
        ontop,
        inside,
        next_to,
        facing,
        holds_rh,
        holds_lh,
        between,
        taken_from_top_of,
        taken_from_inside,
        taken_from_next_to,
    ),
    derived=(
        near,
        faced,
        shut_in,
        held,
        right_hand_free,
        left_hand_free,
        hand_free,
        upright,
        taken,
        rests_in,
        carries,
        room_of,
        in_same_room,
        somewhere,
        lies_on,
        lies_in,
        lies_next_to,
        seat_full,
        bed_full,
    ),
)
