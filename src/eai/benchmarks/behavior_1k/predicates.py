"""The predicates of a BEHAVIOR-1K scene, in three layers.

The first layer states the abilities of kinds of objects (synsets), such as ``openable`` and
``removes_soaked``. Its facts never change. They are made with the scene, from the temperatures, solvents and
recipes in the annotations. The second layer, stored predicates, describes the current state (``lies_in``,
``is_open``). The third layer, derived predicates with BDDL's names (``inside``, ``open``), is for goals.
These predicates follow OmniGibson's files below ``object_states/``, which `docs/behavior-1k.md` lists.
"""

from __future__ import annotations

import eai.logic.formula as f
from eai.benchmarks import support
from eai.logic.formula import Exists, ForAll, Implies, Variable
from eai.world.derived import DefinedPredicate, LookupPredicate
from eai.world.relation import ObjectMask
from eai.world.state import State
from eai.world.vocabulary import Predicate, Vocabulary

X, Y, Z = Variable("x"), Variable("y"), Variable("z")
T, H, C, F = Variable("t"), Variable("h"), Variable("c"), Variable("f")
S, W, P = Variable("s"), Variable("w"), Variable("p")
R, I, B, O = Variable("r"), Variable("i"), Variable("b"), Variable("o")  # noqa: E741 - as recipes are read


def _make_ability_predicate(name: str) -> Predicate:
    return Predicate(name, 1, static=True)


def _make_predicate_hidden_in_prompts(name: str, arity: int = 1) -> Predicate:
    return Predicate(name, arity, static=True, visible=False)


# Abilities and classes of objects. They follow from the kind (synset) of an object.
fixed, floor, container, fillable = map(_make_ability_predicate, ("fixed", "floor", "container", "fillable"))
openable, toggleable = map(_make_ability_predicate, ("openable", "toggleable"))
sliceable, diceable, slicer = map(_make_ability_predicate, ("sliceable", "diceable", "slicer"))
cloth, foldable, absorbent = map(_make_ability_predicate, ("cloth", "foldable", "absorbent"))
mixing_tool, mixer, lighter = map(_make_ability_predicate, ("mixing_tool", "mixer", "lighter"))
heat_source, cold_source, flammable = map(
    _make_ability_predicate, ("heat_source", "cold_source", "flammable")
)
washer, dryer, sink = map(_make_ability_predicate, ("washer", "dryer", "sink"))
substance, liquid = map(_make_ability_predicate, ("substance", "liquid"))

# Predicates for rules of BEHAVIOR-1K. Prompts do not list their facts. For each recipe, a scene has an
# object that stands for the recipe, so that facts can state ingredients and products.
visual, heatable, water, boiled_water, recipe, relaxed = map(
    _make_predicate_hidden_in_prompts, ("visual", "heatable", "water", "boiled_water", "recipe", "relaxed")
)
works_on, works_closed, works_inside = map(
    _make_predicate_hidden_in_prompts, ("works_on", "works_closed", "works_inside")
)
by_stirring, by_heat, product, makes_hot, makes_cooked = map(
    _make_predicate_hidden_in_prompts, ("by_stirring", "by_heat", "product", "makes_hot", "makes_cooked")
)
by_floor, gives, fits, part_of = (
    _make_predicate_hidden_in_prompts(n, 2) for n in ("by_floor", "gives", "fits", "part_of")
)
diced_as, diced_cooked_as, melts_to, cooks_to, boils_to = (
    _make_predicate_hidden_in_prompts(n, 2)
    for n in ("diced_as", "diced_cooked_as", "melts_to", "cooks_to", "boils_to")
)
cooks, melts, chills = (_make_predicate_hidden_in_prompts(n, 2) for n in ("cooks", "melts", "chills"))
removes_dry, removes_soaked, removes_running, dissolved_by, washes_off = (
    _make_predicate_hidden_in_prompts(n, 2)
    for n in ("removes_dry", "removes_soaked", "removes_running", "dissolved_by", "washes_off")
)
ingredient, topping, base, raw, cooked_first = (
    _make_predicate_hidden_in_prompts(n, 2) for n in ("ingredient", "topping", "base", "raw", "cooked_first")
)
made_in, heated_by, makes = (
    _make_predicate_hidden_in_prompts(n, 2) for n in ("made_in", "heated_by", "makes")
)
RULES = tuple([item for item in globals().values() if isinstance(item, Predicate) and item.arity == 2])
"""Predicates with two arguments that state rules of BEHAVIOR-1K, such as the ingredients of recipes."""

# States of one object.
present, held, robot_on = Predicate("present", 1), Predicate("held", 1), Predicate("robot_on", 1, single=True)
is_open, is_toggled_on = Predicate("is_open", 1), Predicate("is_toggled_on", 1)
is_cooked, is_frozen, is_hot = Predicate("is_cooked", 1), Predicate("is_frozen", 1), Predicate("is_hot", 1)
is_folded, is_unfolded = Predicate("is_folded", 1), Predicate("is_unfolded", 1)
is_on_fire, is_broken = Predicate("is_on_fire", 1), Predicate("is_broken", 1)
STATES = (
    *(is_cooked, is_frozen, is_open, is_folded, is_unfolded, is_toggled_on, is_hot, is_on_fire, is_broken),
)
"""The states of objects that goals mention."""

# Positions of objects. An object has at most one support.
lies_in, lies_on = Predicate("lies_in", 2, single=True), Predicate("lies_on", 2, single=True)
attached_to, laid_over = Predicate("attached_to", 2, single=True), Predicate("laid_over", 2, single=True)
draped_on = Predicate("draped_on", 2, single=True)
stands_by, stands_under = Predicate("stands_by", 2), Predicate("stands_under", 2)
_SUPPORTS = (lies_in, lies_on, attached_to, laid_over, draped_on)
SUPPORTS = tuple([relation.name for relation in _SUPPORTS])
"""The stored relations between an object and the object that supports it."""

# Substances.
has_cover, has_in, full_of = Predicate("has_cover", 2), Predicate("has_in", 2), Predicate("full_of", 2)
soaked_with = Predicate("soaked_with", 2)

# Derived.
carries, carried_by, within = support.make_predicates_carries_carried_by_within(_SUPPORTS)


def _find_floor_of_unsupported_object(state: State, obj: int) -> ObjectMask:
    """Return, as a bit mask, the floor of an object without support.

    For a held object this is the robot's floor, for any other object the floor of the object's room.
    """
    return state.mask("robot_on") if state.mask("held") >> obj & 1 else state.relation("by_floor").row(obj)


floor_of = LookupPredicate(
    "floor_of",
    2,
    support.make_lookup_of_floor_under_object(SUPPORTS, _find_floor_of_unsupported_object),
    ("floor", "held", "robot_on", "by_floor", *SUPPORTS),
    support.make_predicate_for_floor_of_object(
        "floor_of", floor, carries, (held(X) & robot_on(Y)) | (~held(X) & by_floor(X, Y))
    ),
    single=True,
    inverse=support.make_cached_inverse_of_lookup_function(
        support.make_lookup_of_floor_under_object(SUPPORTS, _find_floor_of_unsupported_object)
    ),
)
real = DefinedPredicate(
    "real", (X,), present(X) | held(X) | Exists(Y, carries(Y, X)) | Exists(C, has_in(C, X) | has_cover(C, X))
)
closed = DefinedPredicate("closed", (X,), openable(X) & ~is_open(X))
shut_in = DefinedPredicate("shut_in", (X,), Exists(Y, closed(Y) & within(X, Y)))
hands_full = DefinedPredicate("hands_full", (), Exists(X, held(X) & Exists(Y, held(Y) & ~f.Equals(X, Y))))
working = DefinedPredicate(
    "working", (H,), (~works_on(H) | is_toggled_on(H)) & (~works_closed(H) | ~is_open(H) | ~openable(H))
)
exposed_to = DefinedPredicate(
    "exposed_to", (X, H), (works_inside(H) & within(X, H)) | (~works_inside(H) & carried_by(X, H))
)
holds_all = DefinedPredicate(
    "holds_all",
    (R, C),
    ForAll(I, Implies(ingredient(R, I), real(I) & (has_in(C, I) | carried_by(I, C))))
    & ForAll(I, Implies(topping(R, I), real(I) & Exists(B, base(R, B) & (has_cover(B, I) | carries(B, I)))))
    & ForAll(I, Implies(raw(R, I), ~is_cooked(I)))
    & ForAll(I, Implies(cooked_first(R, I), is_cooked(I))),
)
ready = DefinedPredicate(
    "ready", (R, C), holds_all(R, C) & (relaxed(R) | ForAll(S, Implies(has_in(C, S), ingredient(R, S))))
)

_BASIC_DERIVED = tuple(
    [item for item in globals().values() if isinstance(item, DefinedPredicate | LookupPredicate)]
)

# Derived predicates that goals use.


GOAL_STATES = (*(DefinedPredicate(state.name.removeprefix("is_"), (X,), state(X)) for state in STATES), real)
STORED = {
    "inside": lies_in,
    "ontop": lies_on,
    "nextto": stands_by,
    "under": stands_under,
    "attached": attached_to,
    "overlaid": laid_over,
    "draped": draped_on,
    "covered": has_cover,
    "contains": has_in,
    "filled": full_of,
    "saturated": soaked_with,
}
"""Mapping from a relation's name in BDDL to the stored predicate for its facts.

All other relations are computed from stored predicates.
"""

GOAL_RELATIONS = (
    DefinedPredicate("inside", (X, Y), within.definition, within.values),
    DefinedPredicate("touching", (X, Y), carries(X, Y) | carries(Y, X) | stands_by(X, Y)),
    *(DefinedPredicate(name, (X, Y), stored(X, Y)) for name, stored in STORED.items() if name != "inside"),
)
GOAL_PREDICATES = (*(state.name for state in GOAL_STATES), *(relation.name for relation in GOAL_RELATIONS))
"""The predicates that goals and prompts use."""

VOCABULARY = Vocabulary(
    predicates=tuple([item for item in globals().values() if isinstance(item, Predicate)]),
    derived=(*_BASIC_DERIVED, *(state for state in GOAL_STATES if state is not real), *GOAL_RELATIONS),
)
"""All predicates of the BEHAVIOR-1K domain: stored predicates, then predicates computed from them."""
