"""The predicates of a BEHAVIOR scene, in two layers.

Stored predicates describe each object by itself: ``is_open``, ``lies_in``. Derived predicates with BDDL's
names (``open``, ``inside``) are the predicates of goals: a sliced object has a property if both halves have
it, and an object in a bowl in a fridge is inside the fridge too.
"""

from __future__ import annotations

import eai.logic.formula as f
from eai.benchmarks import support
from eai.world.derived import DefinedPredicate, LookupFunction, LookupPredicate
from eai.world.relation import ObjectMask, iterate_bits
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary

_SUPPORTS = ("lies_in", "lies_on")


def make_related_objects_lookup(relation: str) -> LookupFunction:
    """Return a function that finds, as a bit mask, the objects to which a relation relates an object."""

    def find_objects_related_to_first_argument(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        return state.relation(relation).row(arguments[0])

    return find_objects_related_to_first_argument


def extend_lookup_to_sliced_objects(lookup: LookupFunction) -> LookupFunction:
    """Return a lookup function that also works for sliced objects.

    For a sliced object, it returns the objects that `lookup` returns for both halves. For other objects, it
    returns the objects that `lookup` returns.
    """

    def apply_lookup_to_object_or_sliced_halves(state: State, arguments: tuple[int, ...]) -> ObjectMask:
        (x,) = arguments
        halves = state.relation("part_of").column(x) if state.mask("is_sliced") >> x & 1 else 0
        if not halves:
            return lookup(state, arguments)
        common = state.scene.everything
        for half in iterate_bits(halves):
            common &= lookup(state, (half,))
        return common

    return apply_lookup_to_object_or_sliced_halves


def _find_floor_under(state: State, unsupported_object: int) -> ObjectMask:
    """Return, as a bit mask, the floor under an object that lies in or on no other object."""
    return state.relation("stands_on").row(unsupported_object)


X = f.Variable("x")
Y = f.Variable("y")
Z = f.Variable("z")
P = f.Variable("p")

# Predicates for abilities and kinds of objects. No action changes their facts.
cookable = Predicate("cookable", 1, static=True)
burnable = Predicate("burnable", 1, static=True)
dustyable = Predicate("dustyable", 1, static=True)
freezable = Predicate("freezable", 1, static=True)
openable = Predicate("openable", 1, static=True)
sliceable = Predicate("sliceable", 1, static=True)
soakable = Predicate("soakable", 1, static=True)
stainable = Predicate("stainable", 1, static=True)
toggleable = Predicate("toggleable", 1, static=True)
slicer = Predicate("slicer", 1, static=True)
cleaning_tool = Predicate("cleaning_tool", 1, static=True)
cold_source = Predicate("cold_source", 1, static=True)
floor = Predicate("floor", 1, static=True)
sink = Predicate("sink", 1, static=True)
dishwasher = Predicate("dishwasher", 1, static=True)
teapot = Predicate("teapot", 1, static=True)
saucepan = Predicate("saucepan", 1, static=True)
detergent = Predicate("detergent", 1, static=True)
ungraspable = Predicate("ungraspable", 1, static=True, visible=False)  # by its volume

# States of one object.
is_cooked = Predicate("is_cooked", 1)
is_burnt = Predicate("is_burnt", 1)
is_dusty = Predicate("is_dusty", 1)
is_frozen = Predicate("is_frozen", 1)
is_open = Predicate("is_open", 1)
is_sliced = Predicate("is_sliced", 1)
is_soaked = Predicate("is_soaked", 1)
is_stained = Predicate("is_stained", 1)
is_toggled_on = Predicate("is_toggled_on", 1)

# Position of the robot, and objects in its hands.
in_left_hand = Predicate("in_left_hand", 1, single=True)
in_right_hand = Predicate("in_right_hand", 1, single=True)
robot_on = Predicate("robot_on", 1)

# Relations that never change. Comparisons of volumes are computed when a scene is loaded.
part_of = Predicate("part_of", 2, static=True)
larger = Predicate("larger", 2, static=True, visible=False)
much_larger = Predicate("much_larger", 2, static=True, visible=False)

# Positions of objects. An object lies in or on at most one other object.
lies_in = Predicate("lies_in", 2, single=True)
lies_on = Predicate("lies_on", 2, single=True)
stands_on = Predicate("stands_on", 2)
stands_under = Predicate("stands_under", 2)
stands_by = Predicate("stands_by", 2)

LOOSE_RELATIONS = (stands_on, stands_under, stands_by)
"""Relations other than lying in or on an object. Initial facts are added to a state in this order."""

STATES = (
    (cookable, is_cooked),
    (burnable, is_burnt),
    (dustyable, is_dusty),
    (freezable, is_frozen),
    (openable, is_open),
    (sliceable, is_sliced),
    (soakable, is_soaked),
    (stainable, is_stained),
    (toggleable, is_toggled_on),
)
"""Pairs of an ability of objects and the state that this ability makes possible."""

# Derived.
part = DefinedPredicate("part", (X,), f.Exists(Y, part_of(X, Y)))
cut_up = DefinedPredicate("cut_up", (X,), is_sliced(X) & ~f.Exists(Y, part_of(X, Y)))
halved = DefinedPredicate("halved", (X,), is_sliced(X) & f.Exists(P, part_of(P, X)))
held = DefinedPredicate("held", (X,), in_left_hand(X) | in_right_hand(X))
hands_full = DefinedPredicate("hands_full", (), f.Exists(X, in_left_hand(X)) & f.Exists(X, in_right_hand(X)))
closed = DefinedPredicate("closed", (X,), openable(X) & ~is_open(X))
labelled = DefinedPredicate(
    "labelled", (X,), f.Or(tuple(f.Exists(Y, r(X, Y) | r(Y, X)) for r in LOOSE_RELATIONS))
)
carries, carried_by, within = support.make_predicates_carries_carried_by_within((lies_in, lies_on))
shut_in = DefinedPredicate("shut_in", (X,), f.Exists(Y, closed(Y) & within(X, Y)))
floor_below = LookupPredicate(
    "floor_below",
    2,
    support.make_lookup_of_floor_under_object(_SUPPORTS, _find_floor_under),
    (*_SUPPORTS, "floor", "stands_on"),
    support.make_predicate_for_floor_of_object("floor_below", floor, carries, stands_on(X, Y)),
)

_BASIC_DERIVED = tuple(
    [item for item in globals().values() if isinstance(item, DefinedPredicate | LookupPredicate)]
)

# Derived predicates that goals use.


def _make_predicate_for_state_goals(name: str, predicate_ignoring_slicing: Predicate) -> DefinedPredicate:
    """Return the predicate with which goals ask for a state of an object, such as *cooked*.

    The predicate holds for a sliced object if the stored state holds for all halves of the object.
    """
    of_parts = f.ForAll(P, f.Implies(part_of(P, X), predicate_ignoring_slicing(P)))
    return DefinedPredicate(name, (X,), (predicate_ignoring_slicing(X) & ~halved(X)) | (halved(X) & of_parts))


def _make_predicate_for_relation_goals(
    name: str, predicate_ignoring_slicing: Predicate | DefinedPredicate
) -> DefinedPredicate:
    """Return a relation for goals. It holds for a sliced object if it holds for all halves of the object."""
    values = (
        predicate_ignoring_slicing.values
        if isinstance(predicate_ignoring_slicing, DefinedPredicate)
        else None
    )
    of_parts = f.ForAll(P, f.Implies(part_of(P, X), predicate_ignoring_slicing(P, Y)))
    seen = (predicate_ignoring_slicing(X, Y) & ~halved(X)) | (halved(X) & of_parts)
    return DefinedPredicate(
        name,
        (X, Y),
        seen,
        extend_lookup_to_sliced_objects(
            values or make_related_objects_lookup(predicate_ignoring_slicing.name)
        ),
    )


GOAL_STATES = tuple(
    _make_predicate_for_state_goals(state.name.removeprefix("is_"), state) for _, state in STATES
)
STORED = {
    "inside": lies_in,
    "ontop": lies_on,
    "onfloor": stands_on,
    "under": stands_under,
    "nextto": stands_by,
}
"""Name of a relation in BDDL -> stored relation. All other relations are computed from stored relations.

Initial facts are added to a state in this order.
"""

GOAL_RELATIONS = tuple(
    _make_predicate_for_relation_goals(name, within if stored is lies_in else stored)
    for name, stored in STORED.items()
)
directly_inside = _make_predicate_for_relation_goals("directly_inside", lies_in)

VOCABULARY = Vocabulary(
    predicates=tuple([item for item in globals().values() if isinstance(item, Predicate)]),
    derived=(*_BASIC_DERIVED, *GOAL_STATES, *GOAL_RELATIONS, directly_inside),
)
"""All predicates of the BEHAVIOR domain: stored predicates, then predicates computed from them."""
