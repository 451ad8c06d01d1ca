"""What can be said about a VirtualHome scene.

Names are those of the data set's temporal formulas: ``ON`` is the state of a device, ``ONTOP`` the relation
that scene graphs call ON, ``NEXT_TO`` the one that they call CLOSE.
"""

from __future__ import annotations

from eai.benchmarks.virtualhome.places import full_bed, full_seat, origins, rooms
from eai.logic.formula import Exists, Variable
from eai.world.frame import AGENT
from eai.world.vocabulary import Computed, Defined, Lookup, Predicate, Vocabulary

X = Variable("x")
Y = Variable("y")
R = Variable("r")

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
taken_from_top_of = Predicate("TAKEN_FROM_TOP_OF", 2, visible=False)
taken_from_inside = Predicate("TAKEN_FROM_INSIDE", 2, visible=False)
taken_from_next_to = Predicate("TAKEN_FROM_NEXT_TO", 2, visible=False)

# Derived.
near = Defined(
    "near",
    (X,),
    next_to(AGENT, X) | Exists(Y, next_to(AGENT, Y) & (next_to(Y, X) | ontop(X, Y))),
)
faced = Defined("faced", (X,), facing(AGENT, X) | Exists(Y, facing(AGENT, Y) & facing(Y, X)))
shut_in = Defined("shut_in", (X,), Exists(Y, inside(X, Y) & ~room(Y) & closed(Y)))
held = Defined("held", (X,), holds_rh(AGENT, X) | holds_lh(AGENT, X))
right_hand_free = Defined("right_hand_free", (), ~Exists(Y, holds_rh(AGENT, Y)))
left_hand_free = Defined("left_hand_free", (), ~Exists(Y, holds_lh(AGENT, Y)))
hand_free = Defined("hand_free", (), right_hand_free() | left_hand_free())
upright = Defined("upright", (), ~sitting(AGENT) & ~lying(AGENT))
taken = Defined(
    "taken",
    (X,),
    Exists(Y, taken_from_top_of(X, Y) | taken_from_inside(X, Y) | taken_from_next_to(X, Y)),
)
room_of = Lookup("room_of", 2, rooms(), reads=("ROOM", "INSIDE"))
in_same_room = Defined("in_same_room", (X,), Exists(R, room_of(AGENT, R) & room_of(X, R)))
somewhere = Defined("somewhere", (X,), Exists(R, room_of(X, R)))
lies_on, lies_in, lies_next_to = (
    Lookup(name, 2, origins(place), reads=("ROOM", "ONTOP", "INSIDE", "NEXT_TO"))
    for place, name in enumerate(("lies_on", "lies_in", "lies_next_to"))
)
seat_full = Computed("seat_full", 1, full_seat, reads=("ONTOP",))
bed_full = Computed("bed_full", 1, full_bed, reads=("ONTOP",))

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
