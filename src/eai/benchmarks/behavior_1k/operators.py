"""The actions of BEHAVIOR-1K, each with its ordered checks and its effects.

OmniGibson simulates physics; these operators model the simulator symbolically. Each docstring names the
source: ``primitives`` is ``action_primitives/symbolic_semantic_action_primitives.py``, ``rules`` is
``transition_rules.py``, ``states`` is ``object_states/``. If sources leave a question open, one of the
decisions D1 to D11 in `docs/behavior-1k.md` answers it. `READING` names the present set of decisions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

from eai.benchmarks.behavior_1k import predicates as p
from eai.benchmarks.behavior_1k.predicates import C, F, H, I, O, P, R, S, T, W, X, Y, Z
from eai.logic.formula import Equals, Exists, Formula, Implies, Variable
from eai.world.domain import Domain
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When, make_symmetric_effects
from eai.world.history import find_when_action_was_possible
from eai.world.operator import (
    Check,
    Operator,
    OperatorRole,
    additional_step,
    affordance,
    missing_step,
    sort_checks_in_paper_order,
)
from eai.world.vocabulary import Predicate

READING = "b1k-1"
"""Name of this package's decisions D1 to D11, which settle points that the data leave open.

If a decision in `docs/behavior-1k.md` changes, this name changes.
"""

MOVABLE = affordance(~p.fixed(X), "{x} cannot be moved")
HAND_FREE = missing_step(~p.hands_full(), "both hands are full")


def require_existing(obj: Variable) -> Check:
    """Return the check that an object exists now: it has been made, and has not been used up."""
    return missing_step(p.real(obj), f"{{{obj.name}}} does not exist now")


def require_reachable(obj: Variable) -> Check:
    """Return the check that an object is in no closed container."""
    shut = Exists(Z, p.closed(Z) & p.within(obj, Z))
    return missing_step(~p.shut_in(obj), f"{{{obj.name}}} is inside something that is closed", witness=shut)


def forbid_substance_or_recipe(obj: Variable) -> Check:
    """Return the check against arguments that are substances or recipes."""
    reason = f"{{{obj.name}}} is a substance: only what holds it can be handled"
    return affordance(~p.substance(obj) & ~p.recipe(obj), reason)


def require_in_hand(obj: Variable) -> Check:
    """Return the check that the robot holds an object."""
    return missing_step(p.held(obj), f"{{{obj.name}}} is not in a hand")


def require_different(one: Variable, other: Variable) -> Check:
    """Return the check that two arguments of an action are different objects."""
    return affordance(~Equals(one, other), f"{{{one.name}}} cannot be used with itself")


def require_ability(obj: Variable, ability: Predicate, reason: str) -> Check:
    """Return the check that the kind of an object has an ability, such as being openable."""
    return affordance(ability(obj), f"{{{obj.name}}} {reason}")


def make_effects_of_leaving_place(obj: Variable) -> tuple[Effect, ...]:
    """Return effects that remove an object from its support and from its neighbours."""
    relations = (p.lies_in, p.lies_on, p.laid_over, p.draped_on, p.stands_under)
    return (
        *(Delete(relation(obj, ANYTHING)) for relation in relations),
        *make_symmetric_effects(Delete, p.stands_by(obj, ANYTHING)),
        Delete(p.stands_under(ANYTHING, obj)),
    )


def make_effects_of_using_up(obj: Variable) -> tuple[Effect, ...]:
    """Return effects after which an object does not exist, because it has been used up."""
    states = (p.is_cooked, p.is_frozen, p.is_hot, p.is_on_fire, p.present, p.held)
    relations = (p.attached_to, p.has_cover, p.soaked_with)
    return (
        *make_effects_of_leaving_place(obj),
        *(Delete(relation(obj, ANYTHING)) for relation in relations),
        *(Delete(state(obj)) for state in states),
    )


def make_effects_of_putting_beside(obj: Variable, neighbour: Variable) -> tuple[Effect, ...]:
    """Return effects that put an object where its neighbour is.

    It then lies in the same container, on the same support, or on the same floor.
    """
    return (
        Let(C, p.lies_in(neighbour, C), (Add(p.lies_in(obj, C)),)),
        Let(C, p.lies_on(neighbour, C), (Add(p.lies_on(obj, C)),)),
        When(
            ~Exists(C, p.lies_in(neighbour, C) | p.lies_on(neighbour, C)),
            (Let(F, p.floor_of(neighbour, F), (Add(p.lies_on(obj, F)),)),),
        ),
    )


def _make_effect_of_going_to(obj: Variable) -> Effect:
    return Let(F, p.floor_of(obj, F), (Delete(p.robot_on(ANYTHING)), Add(p.robot_on(F))))


def make_navigate_action() -> Operator:
    """Return the action NAVIGATE_TO (after OmniGibson's primitive NAVIGATE_TO)."""
    return Operator(
        "NAVIGATE_TO",
        (X,),
        (require_existing(X),),
        (_make_effect_of_going_to(X),),
        "go to the object",
        role=OperatorRole.MOVEMENT,
    )


def make_grasp_action() -> Operator:
    """Return the action GRASP (after OmniGibson's primitive GRASP). The action names no hand."""
    checks = (
        MOVABLE,
        affordance(~p.floor(X), "{x} is a floor"),
        additional_step(~p.held(X), "{x} is in a hand already"),
        require_existing(X),
        HAND_FREE,
        missing_step(
            ~Exists(Y, p.attached_to(X, Y)),
            "{x} is attached to something",
            witness=Exists(Y, p.attached_to(X, Y)),
        ),
        require_reachable(X),
    )
    text = "take the object, with all that is in or on it, into a free hand"
    return Operator(
        "GRASP",
        (X,),
        checks,
        (*make_effects_of_leaving_place(X), Add(p.held(X))),
        text,
        role=OperatorRole.TAKES,
    )


def make_release_action() -> Operator:
    """Return the action RELEASE (after OmniGibson's primitive RELEASE). The object falls to the floor."""
    effects = (Delete(p.held(X)), Let(F, p.robot_on(F), (Add(p.lies_on(X, F)),)))
    text = "let go of the object in a hand; it comes to lie on the floor where the robot is"
    return Operator("RELEASE", (X,), (require_in_hand(X),), effects, text, role=OperatorRole.RELEASES)


def _make_placing_action(
    name: str, text: str, effects: tuple[Effect, ...], *checks: Check, targets: tuple[Variable, ...] = (Y,)
) -> Operator:
    needed = [require_in_hand(X)]
    for target in targets:
        needed += [
            require_different(X, target),
            require_existing(target),
            missing_step(~p.carried_by(target, X), f"{{{target.name}}} is carried by {{x}}"),
            require_reachable(target),
        ]
    return Operator(name, (X, *targets), (*needed, *checks), (Delete(p.held(X)), *effects), text)


def make_placing_actions() -> Iterator[Operator]:
    """Yield all actions that place a held object.

    They follow OmniGibson's primitives PLACE_ON_TOP and PLACE_INSIDE, and its object states next_to, under,
    overlaid, draped, attached_to.
    """
    first, is_cloth = "the first object, which is in a hand,", require_ability(X, p.cloth, "is no cloth")
    inside = require_ability(Y, p.container, "has no inside"), missing_step(~p.closed(Y), "{y} is closed")
    fits = affordance(p.fits(X, Y), "{x} cannot be attached to {y}")
    for name, relation, text, checks in (
        ("PLACE_ONTOP", p.lies_on, f"put {first} onto the second", ()),
        ("PLACE_INSIDE", p.lies_in, f"put {first} into the second", inside),
        ("OVERLAY", p.laid_over, "spread the first object, a cloth in a hand, over the second", (is_cloth,)),
        ("DRAPE", p.draped_on, "hang the first object, a cloth in a hand, over the second", (is_cloth,)),
        ("ATTACH", p.attached_to, f"attach {first} to the second", (fits,)),
    ):
        yield _make_placing_action(name, text, (Add(relation(X, Y)),), *checks)
    beside, under = make_symmetric_effects(Add, p.stands_by(X, Y)), Add(p.stands_under(X, Y))
    yield _make_placing_action(
        "PLACE_UNDER", f"put {first} under the second", (under, *make_effects_of_putting_beside(X, Y))
    )
    yield _make_placing_action(
        "PLACE_NEXTTO", f"put {first} next to the second", (*beside, *make_effects_of_putting_beside(X, Y))
    )
    together = Exists(C, p.carries(C, Y) & p.carries(C, Z)) | Exists(F, p.floor_of(Y, F) & p.floor_of(Z, F))
    yield _make_placing_action(
        "PLACE_BETWEEN",
        f"put {first} next to both the second and the third",
        (*beside, *make_symmetric_effects(Add, p.stands_by(X, Z)), *make_effects_of_putting_beside(X, Y)),
        require_different(Y, Z),
        missing_step(together, "{y} and {z} are not in one place"),
        targets=(Y, Z),
    )


def make_detach_action() -> Operator:
    """Return the action DETACH (after OmniGibson's object state attached_to)."""
    checks = (
        require_existing(X),
        missing_step(p.attached_to(X, Y), "{x} is not attached to {y}"),
        HAND_FREE,
        require_reachable(X),
    )
    effects = (Delete(p.attached_to(X, Y)), *make_effects_of_leaving_place(X), Add(p.held(X)))
    text = "detach the first object from the second, into a free hand"
    return Operator("DETACH", (X, Y), checks, effects, text, role=OperatorRole.TAKES)


def _make_action_changing_object_state(
    name: str,
    ability: Predicate,
    state: Predicate,
    text: str,
    *effects: Effect,
    to: bool,
    hand: Check = HAND_FREE,
) -> Operator:
    already = f"{{x}} is {'' if to else 'not '}{state.name.removeprefix('is_').replace('_', ' ')} already"
    checks = (
        require_ability(X, ability, f"is not {ability.name}"),
        additional_step(~state(X) if to else state(X), already.replace("not open already", "closed already")),
        require_existing(X),
        hand,
        require_reachable(X),
    )
    return Operator(name, (X,), checks, (Add(state(X)) if to else Delete(state(X)), *effects), text)


def make_actions_changing_object_states() -> Iterator[Operator]:
    """Yield the actions that set states: OPEN, CLOSE, TOGGLE_ON, TOGGLE_OFF, FOLD and UNFOLD.

    The first four actions follow OmniGibson's primitives of these names. FOLD and UNFOLD follow its object
    state ``folded``.
    """
    hand = missing_step(p.held(X) | ~p.hands_full(), "both hands are full", (~p.hands_full(),))
    yield _make_action_changing_object_state("OPEN", p.openable, p.is_open, "open the object", to=True)
    yield _make_action_changing_object_state("CLOSE", p.openable, p.is_open, "close the object", to=False)
    yield _make_action_changing_object_state(
        "TOGGLE_ON", p.toggleable, p.is_toggled_on, "switch the object on", to=True, hand=hand
    )
    yield _make_action_changing_object_state(
        "TOGGLE_OFF", p.toggleable, p.is_toggled_on, "switch the object off", to=False, hand=hand
    )
    unfolded, folded = Delete(p.is_unfolded(X)), Delete(p.is_folded(X))
    yield _make_action_changing_object_state(
        "FOLD", p.foldable, p.is_folded, "fold the object", unfolded, to=True
    )
    yield _make_action_changing_object_state(
        "UNFOLD", p.foldable, p.is_unfolded, "unfold the object", folded, to=True
    )


def make_slice_action() -> Operator:
    """Return the action SLICE, which replaces an object by two halves.

    The halves get the place and the states of the object, and the substances that cover the object. The
    action is modelled on OmniGibson's primitive CUT and transition rule SlicingRule.
    """
    halves = p.part_of(P, X)
    inherited = (
        When(state(X), (ForEach(P, halves, (Add(state(P)),)),))
        for state in (p.is_cooked, p.is_frozen, p.is_hot)
    )
    placed = (
        Let(C, relation(X, C), (ForEach(P, halves, (Add(relation(P, C)),)),))
        for relation in (p.lies_in, p.lies_on)
    )
    covered = ForEach(S, p.has_cover(X, S), (ForEach(P, halves, (Add(p.has_cover(P, S)),)),))
    effects = (
        ForEach(P, halves, (Add(p.present(P)),)),
        *placed,
        *inherited,
        covered,
        *make_effects_of_using_up(X),
    )
    text = "cut the first object into halves with the second, which is in a hand"
    return Operator("SLICE", (X, T), _require_cutting_tool(p.sliceable, "cannot be sliced"), effects, text)


def _require_cutting_tool(ability: Predicate, reason: str) -> tuple[Check, ...]:
    return (
        require_ability(X, ability, reason),
        require_ability(T, p.slicer, "cannot cut"),
        require_existing(X),
        require_in_hand(T),
        missing_step(~p.held(X), "{x} is in a hand"),
        require_reachable(X),
    )


def make_dice_action() -> Operator:
    """Return the action DICE, which replaces an object by its diced pieces (a substance).

    The pieces are in the container or on the support of the object. The action follows OmniGibson's
    transition rule DicingRule.
    """
    diced = (p.diced_as(X, S) & ~p.is_cooked(X)) | (p.diced_cooked_as(X, S) & p.is_cooked(X))

    def make_effect_placing_diced_food(container_condition: Formula, *relations: Predicate) -> Effect:
        return ForEach(
            C, container_condition, (ForEach(S, diced, tuple(Add(relation(C, S)) for relation in relations)),)
        )

    effects = (
        ForEach(S, diced, (Add(p.present(S)),)),
        make_effect_placing_diced_food(p.lies_in(X, C) & p.fillable(C), p.has_in, p.full_of),
        make_effect_placing_diced_food(p.lies_in(X, C) & ~p.fillable(C), p.has_cover),
        make_effect_placing_diced_food(p.lies_on(X, C), p.has_cover),
        *make_effects_of_using_up(X),
    )
    text = "cut the first object into dice with the second, which is in a hand"
    return Operator("DICE", (X, T), _require_cutting_tool(p.diceable, "cannot be diced"), effects, text)


# Substances that can be poured out of an object: in it, given by it (a tap), or lying on it, except stains.
POURABLE = p.has_in(X, S) | p.gives(X, S) | (p.has_cover(X, S) & ~p.visual(S))
HOLDS_SOMETHING = missing_step(Exists(S, POURABLE), "{x} holds no substance")
RUNNING = missing_step(~p.toggleable(Y) | p.is_toggled_on(Y), "{y} is not switched on")


def make_fill_action() -> Operator:
    """Return the action FILL (after OmniGibson's object state particle_source_or_sink)."""
    checks = (
        require_ability(X, p.fillable, "cannot be filled"),
        affordance(p.fixed(Y) & Exists(S, p.gives(Y, S)), "{y} gives nothing"),
        require_in_hand(X),
        missing_step(~p.closed(X), "{x} is closed"),
        RUNNING,
    )
    effects = (ForEach(S, p.gives(Y, S), (Add(p.has_in(X, S)), Add(p.full_of(X, S)), Add(p.present(S)))),)
    return Operator(
        "FILL", (X, Y), checks, effects, "fill the first object, which is in a hand, at the second"
    )


def _make_pouring_checks(*extra_checks: Check) -> tuple[Check, ...]:
    return (
        MOVABLE,
        require_different(X, Y),
        require_existing(Y),
        require_in_hand(X),
        *extra_checks,
        require_reachable(Y),
    )


def make_pour_action() -> Operator:
    """Return the action POUR (after OmniGibson's object states contains, filled).

    Some of the substance remains in the vessel (decision D3 in `docs/behavior-1k.md`).
    """
    checks = _make_pouring_checks(
        require_ability(Y, p.fillable, "cannot be filled"),
        HOLDS_SOMETHING,
        missing_step(~p.closed(Y), "{y} is closed"),
    )
    effects = (
        ForEach(S, POURABLE, (Add(p.has_in(Y, S)), Add(p.present(S)))),
        ForEach(S, p.full_of(X, S) | p.gives(X, S), (Add(p.full_of(Y, S)),)),
    )
    text = "pour some of what is in or on the first object, which is in a hand, into the second"
    return Operator("POUR", (X, Y), checks, effects, text)


def make_emptying_action() -> Operator:
    """Return the action EMPTY (after OmniGibson's object state particle_source_or_sink).

    Nothing remains in the vessel (decision D3 in `docs/behavior-1k.md`).
    """
    spilt = p.has_in(X, S) | (p.has_cover(X, S) & ~p.visual(S))
    things = p.lies_in(Z, X) | p.lies_on(Z, X)
    checks = _make_pouring_checks(
        affordance(p.container(Y) | p.fillable(Y) | p.floor(Y), "{y} takes nothing up"),
        missing_step(~p.carried_by(Y, X), "{y} is carried by {x}"),
        missing_step(Exists(S, p.has_in(X, S) | p.has_cover(X, S)) | Exists(Z, things), "{x} is empty"),
        missing_step(~p.closed(Y), "{y} is closed"),
    )
    effects = (
        ForEach(S, spilt & ~p.sink(Y), (Add(p.has_in(Y, S)),)),
        ForEach(S, p.full_of(X, S) & ~p.sink(Y), (Add(p.full_of(Y, S)),)),
        ForEach(S, spilt, (Delete(p.has_in(X, S)), Delete(p.full_of(X, S)), Delete(p.has_cover(X, S)))),
        ForEach(Z, things, (Delete(p.lies_in(Z, X)), Delete(p.lies_on(Z, X)), Add(p.lies_in(Z, Y)))),
    )
    text = "empty all of the first object, which is in a hand, into the second; a sink swallows substances"
    return Operator("EMPTY", (X, Y), checks, effects, text)


def make_apply_substance_action() -> Operator:
    """Return the action APPLY (after OmniGibson's object states particle_modifier, ParticleApplier).

    The action covers an object with the substances of a held object, such as a spray bottle. If the substance
    is a liquid and the object is absorbent, it also soaks the object (decision D10 in `docs/behavior-1k.md`).
    """
    effects = (
        ForEach(S, POURABLE, (Add(p.has_cover(Y, S)), Add(p.present(S)))),
        ForEach(S, POURABLE & p.liquid(S) & p.absorbent(Y), (Add(p.soaked_with(Y, S)),)),
    )
    text = "cover the second object with what is in the first, which is in a hand: spray, spread, sprinkle"
    return Operator("APPLY", (X, Y), _make_pouring_checks(HOLDS_SOMETHING), effects, text)


COVERED = additional_step(Exists(S, p.has_cover(X, S)), "{x} is covered by nothing")


def make_wipe_action() -> Operator:
    """Return the action WIPE (after OmniGibson's primitive WIPE and ParticleRemover)."""
    soaked = p.removes_soaked(T, S) & Exists(W, p.dissolved_by(S, W) & p.soaked_with(T, W))
    off = p.has_cover(X, S) & (p.removes_dry(T, S) | soaked | (p.removes_running(T, S) & p.is_toggled_on(T)))
    able = Exists(
        S, p.has_cover(X, S) & (p.removes_dry(T, S) | p.removes_soaked(T, S) | p.removes_running(T, S))
    )
    checks = (
        COVERED,
        affordance(~Exists(S, p.has_cover(X, S)) | able, "{t} cannot remove what covers {x}"),
        require_existing(X),
        require_in_hand(T),
        missing_step(
            Exists(S, off), "{t} is not soaked with, or does not run as, what removes what covers {x}"
        ),
        require_reachable(X),
    )
    text = "wipe the first object with the second, which is in a hand"
    return Operator("WIPE", (X, T), checks, (ForEach(S, off, (Delete(p.has_cover(X, S)),)),), text)


def make_soak_action() -> Operator:
    """Return the action SOAK (after OmniGibson's primitives SOAK_UNDER and SOAK_INSIDE)."""
    fluid = (p.gives(Y, S) & (~p.toggleable(Y) | p.is_toggled_on(Y) | ~p.fixed(Y))) | p.has_in(Y, S)
    checks = (
        require_ability(X, p.absorbent, "cannot soak anything up"),
        require_different(X, Y),
        require_existing(Y),
        require_in_hand(X),
        missing_step(Exists(S, fluid), "{y} holds nothing, and is not switched on"),
        require_reachable(Y),
    )
    text = "soak the first object, which is in a hand, with what the second gives or holds"
    return Operator("SOAK", (X, Y), checks, (ForEach(S, fluid, (Add(p.soaked_with(X, S)),)),), text)


def make_rinse_action() -> Operator:
    """Return the action RINSE.

    The action removes substances that water dissolves, by OmniGibson's table for washing machines (decision
    D4 in `docs/behavior-1k.md`).
    """
    solvent = Exists(W, p.dissolved_by(S, W) & (p.has_cover(X, W) | p.has_in(Y, W)))
    off = p.has_cover(X, S) & (p.washes_off(Y, S) | solvent)
    checks = (
        affordance(p.sink(Y) & Exists(S, p.gives(Y, S)), "{y} is no sink with water"),
        COVERED,
        require_existing(X),
        require_in_hand(X),
        RUNNING,
        missing_step(Exists(S, off), "water alone does not remove what covers {x}"),
    )
    text = "rinse the first object, which is in a hand, under the second, which runs"
    return Operator("RINSE", (X, Y), checks, (ForEach(S, off, (Delete(p.has_cover(X, S)),)),), text)


def make_recipe_effects(vessel: Variable, recipe_condition: Formula) -> tuple[Effect, ...]:
    """Return the effects of completing recipes: products appear in a vessel, and ingredients are used up.

    Args:
        vessel: the vessel.
        recipe_condition: condition on a recipe, the variable ``r``. Effects apply to recipes that fulfil
            this condition and whose ingredients are ready in the vessel.
    """
    done = recipe_condition & p.ready(R, vessel)
    of_it = Exists(R, p.makes(R, O) & done)
    taken = Exists(R, (p.ingredient(R, I) | p.topping(R, I)) & done)
    return (
        ForEach(
            O,
            p.product(O) & p.substance(O),
            (When(of_it, (Add(p.has_in(vessel, O)), Add(p.full_of(vessel, O)), Add(p.present(O)))),),
        ),
        ForEach(
            O, p.product(O) & ~p.substance(O), (When(of_it, (Add(p.lies_on(O, vessel)), Add(p.present(O)))),)
        ),
        ForEach(O, Exists(R, p.makes(R, O) & p.makes_cooked(R) & done), (Add(p.is_cooked(O)),)),
        ForEach(O, Exists(R, p.makes(R, O) & p.makes_hot(R) & done), (Add(p.is_hot(O)),)),
        ForEach(I, taken & p.substance(I), (Delete(p.has_in(vessel, I)), Delete(p.full_of(vessel, I)))),
        ForEach(I, taken & ~p.substance(I), make_effects_of_using_up(I)),
    )


def make_run_machine_action() -> Operator:
    """Return the action RUN (after OmniGibson's transition rule ToggleableMachineRule).

    Objects that the recipe does not need must be taken out of the machine first (decision D6 in
    `docs/behavior-1k.md`).
    """
    checks = (
        require_existing(H),
        require_ability(H, p.mixer, "is no machine that makes anything of what is in it"),
        missing_step(p.is_toggled_on(H), "{h} is not switched on"),
        missing_step(
            Exists(R, p.made_in(R, H) & p.ready(R, H)),
            "{h} does not hold all that a recipe takes, and nothing else",
        ),
    )
    text = "let the machine, which is switched on, mix what is in it"
    return Operator("RUN", (H,), checks, make_recipe_effects(H, p.made_in(R, H) & ~p.by_heat(R)), text)


def make_stir_action() -> Operator:
    """Return the action STIR (after OmniGibson's transition rule MixingToolRule)."""
    checks = (
        affordance(p.fillable(C), "{c} cannot be filled"),
        require_ability(T, p.mixing_tool, "is no tool for mixing"),
        require_existing(C),
        require_in_hand(T),
        missing_step(
            Exists(R, p.by_stirring(R) & p.ready(R, C)),
            "{c} does not hold all that a recipe takes, and nothing else",
        ),
    )
    text = "stir what is in the first object with the second, which is in a hand"
    return Operator("STIR", (C, T), checks, make_recipe_effects(C, p.by_stirring(R)), text)


def _require_heat_or_cold(source_kind: Predicate, reason: str) -> tuple[Check, ...]:
    return (
        require_ability(H, source_kind, reason),
        require_existing(X),
        require_existing(H),
        missing_step(p.exposed_to(X, H), "{x} is not in or on {h}"),
        missing_step(p.working(H), "{h} does not work: it must be switched on, and closed, if it can be"),
    )


def make_heat_action() -> Operator:
    """Return the action HEAT: a source heats an object with all its contents, and completes recipes in it.

    It follows OmniGibson's object states heat_source_or_sink and cooked, and its transition rules
    CookingSystemRule, CookingObjectRule, MeltingRule.
    """

    def make_warming_effects(obj: Variable, condition: Formula) -> Iterator[Effect]:
        yield ForEach(obj, condition & p.heatable(obj), (Add(p.is_hot(obj)), Delete(p.is_frozen(obj))))
        yield ForEach(obj, condition & p.cooks(H, obj) & ~p.substance(obj), (Add(p.is_cooked(obj)),))

    boils = Exists(W, p.boiled_water(W) & p.has_in(X, W))
    becomes = p.cooks_to(S, O) & p.cooks(H, S)
    softens = p.boils_to(S, O) & p.cooks(H, S)
    molten = Exists(Z, p.melts_to(Z, O) & p.melts(H, Z) & p.carries(X, Z))
    effects = (
        When(p.heatable(X), (Add(p.is_hot(X)), Delete(p.is_frozen(X)))),
        When(p.cooks(H, X) & ~p.substance(X), (Add(p.is_cooked(X)),)),
        *make_warming_effects(Z, p.carried_by(Z, X)),
        ForEach(
            O,
            p.substance(O),
            (
                When(Exists(S, becomes & p.has_in(X, S)), (Add(p.has_in(X, O)), Add(p.present(O)))),
                When(Exists(S, becomes & p.full_of(X, S)), (Add(p.full_of(X, O)),)),
                When(Exists(S, softens & p.has_in(X, S)) & boils, (Add(p.has_in(X, O)), Add(p.present(O)))),
                When(Exists(S, softens & p.full_of(X, S)) & boils, (Add(p.full_of(X, O)),)),
                When(molten & p.fillable(X), (Add(p.has_in(X, O)), Add(p.present(O)))),
                When(molten & ~p.fillable(X), (Add(p.has_cover(X, O)), Add(p.present(O)))),
            ),
        ),
        ForEach(
            S,
            p.has_in(X, S)
            & p.cooks(H, S)
            & (Exists(O, p.cooks_to(S, O)) | (Exists(O, p.boils_to(S, O)) & boils)),
            (Delete(p.has_in(X, S)), Delete(p.full_of(X, S))),
        ),
        ForEach(Z, p.carries(X, Z) & p.melts(H, Z), make_effects_of_using_up(Z)),
        *make_recipe_effects(X, p.made_in(R, X) & p.heated_by(R, H)),
    )
    text = "wait until the first object, in or on the working second, is hot with all that is in or on it"
    return Operator("HEAT", (X, H), _require_heat_or_cold(p.heat_source, "heats nothing"), effects, text)


def make_freeze_action() -> Operator:
    """Return the action FREEZE (after OmniGibson's object states heat_source_or_sink, frozen).

    Nothing freezes without this action (decision D8 in `docs/behavior-1k.md`).
    """
    effects = (
        When(p.chills(H, X), (Add(p.is_frozen(X)),)),
        Delete(p.is_hot(X)),
        ForEach(Z, p.carried_by(Z, X) & p.chills(H, Z), (Add(p.is_frozen(Z)),)),
        ForEach(Z, p.carried_by(Z, X), (Delete(p.is_hot(Z)),)),
        *make_recipe_effects(X, p.made_in(R, X) & p.heated_by(R, H)),
    )
    text = "wait until the first object, which is in the working second, is cold with all that is in or on it"
    return Operator("FREEZE", (X, H), _require_heat_or_cold(p.cold_source, "cools nothing"), effects, text)


def _require_running_machine(machine_ability: Predicate, reason: str) -> tuple[Check, ...]:
    return (
        require_ability(H, machine_ability, reason),
        require_existing(H),
        missing_step(p.is_toggled_on(H), "{h} is not switched on"),
        missing_step(~p.is_open(H), "{h} is open"),
        missing_step(Exists(X, p.within(X, H)), "nothing is in {h}"),
    )


def make_wash_action() -> Operator:
    """Return the action WASH (after OmniGibson's transition rule WasherRule)."""
    solvent = Exists(W, p.dissolved_by(S, W) & p.has_in(H, W))
    off = p.has_cover(X, S) & (p.washes_off(H, S) | solvent)
    effects = (
        ForEach(X, p.within(X, H), (ForEach(S, off, (Delete(p.has_cover(X, S)),)),)),
        ForEach(X, p.within(X, H) & p.absorbent(X), (ForEach(W, p.water(W), (Add(p.soaked_with(X, W)),)),)),
    )
    text = "wait until the washer, which is closed and switched on, has washed what is in it"
    return Operator("WASH", (H,), _require_running_machine(p.washer, "washes nothing"), effects, text)


def make_dry_action() -> Operator:
    """Return the action DRY (after OmniGibson's transition rule DryerRule)."""
    inside = p.within(X, H)
    effects = (
        ForEach(X, inside, (ForEach(W, p.soaked_with(X, W) & p.liquid(W), (Delete(p.soaked_with(X, W)),)),)),
        ForEach(X, inside, (ForEach(W, p.has_cover(X, W) & p.water(W), (Delete(p.has_cover(X, W)),)),)),
    )
    text = "wait until the dryer, which is closed and switched on, has dried what is in it"
    return Operator("DRY", (H,), _require_running_machine(p.dryer, "dries nothing"), effects, text)


def make_ignite_action() -> Operator:
    """Return the action IGNITE (after OmniGibson's object state on_fire)."""
    checks = (
        require_ability(X, p.flammable, "does not burn"),
        require_ability(T, p.lighter, "lights nothing"),
        additional_step(~p.is_on_fire(X), "{x} burns already"),
        require_existing(X),
        require_in_hand(T),
        missing_step(p.is_toggled_on(T), "{t} is not switched on"),
        require_reachable(X),
    )
    text = "set the first object on fire with the second, which is in a hand and switched on"
    return Operator("IGNITE", (X, T), checks, (Add(p.is_on_fire(X)),), text)


def make_wait_action() -> Operator:
    """Return the action WAIT: hours pass. Hot objects cool down, and objects that are wet with water dry.

    Frozen objects thaw, except in a working source of cold. The action is modelled on OmniGibson's object
    state temperature, which decays.
    """
    kept_cold = Exists(Y, p.cold_source(Y) & p.working(Y) & p.exposed_to(X, Y))
    effects = (
        ForEach(X, p.is_frozen(X) & ~kept_cold, (Delete(p.is_frozen(X)),)),
        ForEach(X, p.is_hot(X), (Delete(p.is_hot(X)),)),
        ForEach(
            X, p.real(X), (ForEach(W, p.soaked_with(X, W) & p.water(W), (Delete(p.soaked_with(X, W)),)),)
        ),
    )
    text = "wait for hours: what is frozen thaws outside a freezer, what is hot cools down, what is wet dries"
    return Operator("WAIT", (), (), effects, text)


def add_solid_object_checks_and_robot_movement(operator: Operator) -> Operator:
    """Return a copy of an action that also checks its arguments, and moves the robot.

    The copy checks that arguments are solid objects. It moves the robot to the action's last argument, unless
    the action itself moves the robot or releases an object (decision D1 in `docs/behavior-1k.md`).
    """
    checks = (*map(forbid_substance_or_recipe, operator.parameters), *operator.checks)
    effects = operator.effects
    if operator.parameters and operator.role not in (OperatorRole.MOVEMENT, OperatorRole.RELEASES):
        effects = (*effects, _make_effect_of_going_to(operator.parameters[-1]))
    return sort_checks_in_paper_order(replace(operator, checks=checks, effects=effects))


_MAKERS: tuple[Callable[[], Operator], ...] = (
    *(
        make_navigate_action,
        make_grasp_action,
        make_release_action,
        make_detach_action,
        make_slice_action,
        make_dice_action,
        make_fill_action,
        make_pour_action,
        make_emptying_action,
        make_apply_substance_action,
        make_wipe_action,
        make_soak_action,
        make_rinse_action,
    ),
    *(
        make_run_machine_action,
        make_stir_action,
        make_heat_action,
        make_freeze_action,
        make_wash_action,
        make_dry_action,
        make_ignite_action,
        make_wait_action,
    ),
)


@cache
def build_domain() -> Domain:
    """Return the domain of BEHAVIOR-1K.

    The robot sees the objects that it holds. It sees all objects on its floor that are not in closed
    containers. It sees and reaches objects without a known floor from everywhere. It sees a substance if it
    sees the open container with this substance, its source, or an object covered or soaked with it.
    """
    operators = (
        *make_placing_actions(),
        *make_actions_changing_object_states(),
        *(make() for make in _MAKERS),
    )

    def is_in_sight(obj: Variable) -> Formula:
        here = Implies(Exists(F, p.floor_of(obj, F)), Exists(F, p.robot_on(F) & p.floor_of(obj, F)))
        return p.held(obj) | (~p.shut_in(obj) & here)

    openly = p.has_cover(Y, X) | p.soaked_with(Y, X) | p.gives(Y, X) | (p.has_in(Y, X) & ~p.closed(Y))
    return Domain(
        "behavior-1k",
        p.VOCABULARY,
        tuple(map(add_solid_object_checks_and_robot_movement, operators)),
        find_when_action_was_possible,
        visible=p.real(X) & ((~p.substance(X) & is_in_sight(X)) | Exists(Y, openly & is_in_sight(Y))),
        landmarks=p.floor(X) | p.fixed(X),
    )
