"""The actions of BEHAVIOR, each with its ordered checks and its effects.

The operators follow the paper's description of the simulator. The order of checks is that of the module
``evolving_graph.py`` in the paper's package. `eai.extensions.reference.behavior_quirks` lists the package's
defects.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.predicates import P, X, Y
from eai.logic.formula import Exists, Formula, Implies, Variable
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When, make_symmetric_effects
from eai.world.operator import (
    Check,
    Operator,
    OperatorAlternative,
    OperatorRole,
    additional_step,
    affordance,
    missing_step,
)
from eai.world.vocabulary import Predicate

H = Variable("h")
C = Variable("c")
F = Variable("f")


class _Hand(NamedTuple):
    """A hand: the prefix of its actions' names, and predicates for objects in this and in the other hand."""

    name: str
    holds: Predicate
    other: Predicate

    @property
    def empty_hand_condition(self) -> Formula:
        """Condition that this hand holds no object."""
        return ~Exists(H, self.holds(H))


HANDS = (_Hand("LEFT", p.in_left_hand, p.in_right_hand), _Hand("RIGHT", p.in_right_hand, p.in_left_hand))

# Checks that several actions share.
A_HAND_FREE = missing_step(~p.hands_full(), "both hands are full")


def require_not_in_other_hand(hand: _Hand) -> Check:
    """Return the check that the other hand does not hold the object."""
    return missing_step(~hand.other(X), "{x} is in the other hand already")


def forbid_half_of_unsliced_object(obj: Variable) -> Check:
    """Return the check that a half of an object has been cut off.

    Objects that are no halves pass the check.
    """
    condition = Implies(p.part(obj), p.is_sliced(obj))
    return missing_step(condition, f"{{{obj.name}}} has not been cut off yet")


def require_interactable(obj: Variable) -> tuple[Check, ...]:
    """Return the checks that an object is in no closed container, and has not been sliced.

    After slicing, only the halves of the object can be used.
    """
    shut = Exists(C, p.closed(C) & p.within(obj, C))
    return (
        missing_step(~p.shut_in(obj), f"{{{obj.name}}} is inside something that is closed", witness=shut),
        affordance(~p.cut_up(obj), f"{{{obj.name}}} is sliced; only its parts can be handled"),
        forbid_half_of_unsliced_object(obj),
    )


def add_robot_movement(operator: Operator) -> Operator:
    """Return a copy of an action that also moves the robot to the floor below the action's last argument.

    If there is no such floor, the robot does not move.
    """
    target = operator.parameters[-1]
    go = Let(F, p.floor_below(target, F), (Delete(p.robot_on(ANYTHING)), Add(p.robot_on(F))))
    return replace(operator, effects=(*operator.effects, go))


def make_effects_of_putting_in(obj: Variable, container: Variable) -> tuple[Effect, ...]:
    """Return effects that put a loose object into a container.

    A loose object lies in or on no other object.
    """
    return (Add(p.lies_in(obj, container)),)


def make_effects_of_putting_on(obj: Variable, support: Variable) -> tuple[Effect, ...]:
    """Return effects that put an object, which lies in or on no other object, onto an object or a floor.

    Afterwards the object stands on the floor, or lies on the other object.
    """
    return (
        When(p.floor(support), (Add(p.stands_on(obj, support)),)),
        When(~p.floor(support), (Add(p.lies_on(obj, support)),)),
    )


def make_effects_of_putting_beside(obj: Variable, neighbour: Variable) -> tuple[Effect, ...]:
    """Return effects that put an object beside another object, the neighbour.

    Before, the object lies in or on no other object. Afterwards it lies in the neighbour's container, lies on
    the neighbour's support, or stands on the neighbour's floor. If the neighbour is itself a floor, the
    object stands on that floor.
    """
    support = Exists(C, p.carries(C, neighbour))
    return (
        When(p.floor(neighbour), (Add(p.stands_on(obj, neighbour)),)),
        Let(C, p.lies_in(neighbour, C), (Add(p.lies_in(obj, C)),)),
        Let(C, p.lies_on(neighbour, C), (Add(p.lies_on(obj, C)),)),
        When(~support, (Let(F, p.stands_on(neighbour, F), (Add(p.stands_on(obj, F)),)),)),
    )


def make_effects_of_leaving_support(obj: Variable) -> tuple[Effect, ...]:
    """Return effects after which an object lies in and on no other object, but still on its floor."""
    return Delete(p.lies_in(obj, ANYTHING)), Delete(p.lies_on(obj, ANYTHING))


def make_grasp_action(hand: _Hand) -> Operator:
    """Return the action GRASP of a hand.

    Objects on the grasped object come along, unless they are much larger.
    """
    checks = (
        affordance(~p.floor(X), "{x} is a floor"),
        affordance(~p.ungraspable(X), "{x} is too big to grasp"),
        additional_step(~hand.holds(X), "{x} is in that hand already"),
        require_not_in_other_hand(hand),
        missing_step(hand.empty_hand_condition, "that hand is full"),
        *require_interactable(X),
    )
    effects = (
        Delete(p.stands_on(X, ANYTHING)),
        *make_symmetric_effects(Delete, p.stands_under(X, ANYTHING)),
        *make_symmetric_effects(Delete, p.stands_by(X, ANYTHING)),
        *make_effects_of_leaving_support(X),
        ForEach(C, p.carries(X, C) & p.much_larger(C, X), make_effects_of_leaving_support(C)),
        Add(hand.holds(X)),
    )
    text = "take the object into that hand"
    return Operator(f"{hand.name}_GRASP", (X,), checks, effects, text, role=OperatorRole.TAKES)


def make_release_action(hand: _Hand) -> Operator:
    """Return the action RELEASE of a hand: the held object then stands on the floor on which the robot is."""
    checks = (
        missing_step(~(hand.empty_hand_condition & p.labelled(X)), "that hand holds nothing"),
        additional_step(~hand.empty_hand_condition, "that hand holds nothing"),
        missing_step(hand.holds(X), "that hand holds something other than {x}"),
        *require_interactable(X),
    )
    effects = (Delete(hand.holds(X)), Let(F, p.robot_on(F), (Add(p.stands_on(X, F)),)))
    text = "let go of the object in that hand"
    return Operator(f"{hand.name}_RELEASE", (X,), checks, effects, text, role=OperatorRole.RELEASES)


def require_target_for_placing(hand: _Hand, target: Variable) -> tuple[Check, ...]:
    """Return the checks of placing actions: the hand holds an object that neither is nor carries the target.

    The robot must also be able to act on the target.
    """
    return (
        missing_step(~hand.empty_hand_condition, "that hand holds nothing"),
        missing_step(~hand.holds(target), f"{{{target.name}}} is the object in that hand"),
        missing_step(
            ~Exists(H, hand.holds(H) & p.carried_by(target, H)),
            f"{{{target.name}}} is carried by the object in that hand",
        ),
        *require_interactable(target),
    )


NO_INSIDE = affordance(~p.floor(X), "{x} is a floor, which has no inside")


def make_placing_actions(hand: _Hand) -> Iterator[Operator]:
    """Yield the actions that put the held object down.

    In their effects, the variable ``h`` is the held object.
    """
    free, beside = require_target_for_placing(hand, X), make_symmetric_effects(Add, p.stands_by(H, X))
    fits = affordance(~Exists(H, hand.holds(H) & p.larger(H, X)), "what the hand holds is too big for {x}")
    for name, checks, effects, where in (
        ("ONTOP", free, make_effects_of_putting_on(H, X), "onto the object"),
        (
            "INSIDE",
            (*_require_container_open_and_large_enough(hand, fits), *free),
            make_effects_of_putting_in(H, X),
            "into the object",
        ),
        ("NEXTTO", free, (*beside, *make_effects_of_putting_beside(H, X)), "next to the object"),
        (
            "UNDER",
            free,
            (Add(p.stands_under(H, X)), *make_effects_of_putting_beside(H, X)),
            "under the object",
        ),
    ):
        yield _make_placing_action(hand, name, (X,), checks, effects, where)
    both = (*free, *require_target_for_placing(hand, Y))
    where = "next to the first object and onto the second"
    yield _make_placing_action(
        hand, "NEXTTO_ONTOP", (X, Y), both, (*beside, *make_effects_of_putting_on(H, Y)), where
    )


def _require_container_open_and_large_enough(hand: _Hand, fits_inside: Check) -> tuple[Check, ...]:
    return NO_INSIDE, fits_inside, missing_step(hand.empty_hand_condition | ~p.closed(X), "{x} is closed")


def _make_placing_action(
    hand: _Hand,
    name: str,
    parameters: tuple[Variable, ...],
    checks: tuple[Check, ...],
    effects: tuple[Effect, ...],
    target_text: str,
) -> Operator:
    placed = Let(H, hand.holds(H), (Delete(hand.holds(H)), *effects))
    text = f"put what that hand holds {target_text}"
    return Operator(f"{hand.name}_PLACE_{name}", parameters, checks, (placed,), text)


def make_pouring_actions(hand: _Hand) -> Iterator[Operator]:
    """Yield the actions that pour out the contents of the held object. Variable ``c`` is one content.

    The contents are the objects directly in or on the held object.
    """
    too_big = Exists(H, hand.holds(H) & Exists(C, p.carries(H, C) & p.larger(C, X)))
    fits = affordance(~too_big, "the contents of what the hand holds are too big for {x}")
    empty = Exists(H, hand.holds(H) & ~Exists(C, p.carries(H, C)))
    has_contents = affordance(~empty, "what the hand holds is empty")
    for name, checks, effects, where in (
        (
            "INSIDE",
            _require_container_open_and_large_enough(hand, fits),
            make_effects_of_putting_in(C, X),
            "into the object",
        ),
        ("ONTOP", (has_contents,), make_effects_of_putting_on(C, X), "onto the object"),
    ):
        poured = ForEach(
            C, Exists(H, hand.holds(H) & p.carries(H, C)), (*make_effects_of_leaving_support(C), *effects)
        )
        text = f"pour what is in or on the object in that hand {where}"
        checks = (*checks, *require_target_for_placing(hand, X))
        yield Operator(f"{hand.name}_TRANSFER_CONTENTS_{name}", (X,), checks, (poured,), text)


def make_hand_actions(hand: _Hand) -> tuple[Operator, ...]:
    """Return the actions of one hand, in the order of ``EvalActions`` in the paper's package."""
    ontop, inside, nextto, under, nextto_ontop = make_placing_actions(hand)
    return (
        make_grasp_action(hand),
        ontop,
        inside,
        make_release_action(hand),
        nextto,
        *make_pouring_actions(hand),
        nextto_ontop,
        under,
    )


def make_action_changing_object_state(
    name: str,
    ability: Predicate,
    state: Predicate,
    description: str,
    *,
    to_true: bool,
    first_checks: tuple[Check, ...] = (),
    last_checks: tuple[Check, ...] = (),
    effects: tuple[Effect, ...] = (),
) -> Operator:
    """Return an action that makes a state of an object true or false. The robot needs a free hand."""
    wanted = state(X)
    checks = (
        *first_checks,
        A_HAND_FREE,
        affordance(ability(X), f"{{x}} is not {ability.name}"),
        additional_step(
            ~wanted if to_true else wanted, f"{{x}} {_write_phrase_already_in_state(state, holds=to_true)}"
        ),
        *require_interactable(X),
        *last_checks,
    )
    change = Add(wanted) if to_true else Delete(wanted)
    return Operator(name, (X,), checks, (change, *effects), description)


def make_toggle_on_action() -> Operator:
    """Return the action TOGGLE_ON. A dishwasher then cleans the objects directly in or on the dishwasher."""
    washed = (Delete(p.is_dusty(C)), Delete(p.is_stained(C)))
    return make_action_changing_object_state(
        "TOGGLE_ON",
        p.toggleable,
        p.is_toggled_on,
        "switch the object on",
        to_true=True,
        last_checks=(missing_step(~(p.openable(X) & p.is_open(X)), "{x} is open"),),
        effects=(When(p.dishwasher(X), (ForEach(C, p.carries(X, C), washed),)),),
    )


def make_slice_action() -> Operator:
    """Return the action SLICE: two halves replace an object.

    The halves get the support, the relations and the states of the object.
    """
    parts = p.part_of(P, X)
    states: tuple[Effect, ...] = tuple(
        effect
        for _, state in p.STATES
        if state is not p.is_sliced
        for effect in (
            When(state(X), (ForEach(P, parts, (Add(state(P)),)),)),
            When(~state(X), (ForEach(P, parts, (Delete(state(P)),)),)),
        )
    )
    labels = tuple(
        effect for label in p.LOOSE_RELATIONS for effect in _make_effects_moving_facts_to_sliced_halves(label)
    )
    supports: tuple[Effect, ...] = tuple(
        Let(
            C,
            relation(X, C),
            (
                ForEach(P, parts, (*make_effects_of_leaving_support(P), Add(relation(P, C)))),
                *make_effects_of_leaving_support(X),
            ),
        )
        for relation in (p.lies_in, p.lies_on)
    )
    return make_action_changing_object_state(
        "SLICE",
        p.sliceable,
        p.is_sliced,
        "slice the object with a slicer in a hand",
        to_true=True,
        first_checks=(missing_step(Exists(Y, p.held(Y) & p.slicer(Y)), "no hand holds a slicer"),),
        effects=(ForEach(P, parts, (Add(p.is_sliced(P)),)), *states, *labels, *supports),
    )


def _make_effects_moving_facts_to_sliced_halves(relation: Predicate) -> tuple[Effect, ...]:
    """Return effects that replace the object ``x`` by its halves in all facts of a relation."""
    parts = p.part_of(P, X)
    return (
        ForEach(C, relation(X, C), (ForEach(P, parts, (Add(relation(P, C)),)),)),
        ForEach(C, relation(C, X), (ForEach(P, parts, (Add(relation(C, P)),)),)),
        *make_symmetric_effects(Delete, relation(X, ANYTHING)),
    )


def make_clean_action() -> Operator:
    """Return the action CLEAN: remove dust, then stains. The action succeeds if it removes either."""
    in_sink = Exists(Y, p.carried_by(X, Y) & p.is_toggled_on(Y) & p.sink(Y))
    in_dishwasher = Exists(Y, p.carried_by(X, Y) & p.is_toggled_on(Y) & p.dishwasher(Y))
    tool = Exists(Y, p.held(Y) & p.cleaning_tool(Y))
    wet_tool = Exists(Y, p.held(Y) & p.cleaning_tool(Y) & p.is_soaked(Y))
    detergent = Exists(Y, p.held(Y) & p.detergent(Y))
    checks = (
        affordance(p.dustyable(X) | p.stainable(X), "{x} can be neither dusty nor stained"),
        additional_step(p.is_dusty(X) | p.is_stained(X), "{x} is neither dusty nor stained"),
    )
    tries = (
        _make_cleaning_alternative(
            p.is_dusty,
            in_sink | in_dishwasher | tool,
            "no hand holds a cleaning tool, and {x} is in no running sink or dishwasher",
            "there_is_no_cleaning_tool_running_sink_or_dishwasher_for",
        ),
        _make_cleaning_alternative(
            p.is_stained,
            in_sink | wet_tool | detergent,
            "no hand holds a soaked cleaning tool or detergent, and {x} is in no running sink",
            "there_is_no_soaked_cleaning_tool_detergent_or_running_sink_for",
        ),
    )
    return Operator("CLEAN", (X,), checks, (), "clean the object of dust and stains", alternatives=tries)


def _make_cleaning_alternative(
    dirt: Predicate, cleaning_means: Formula, message_without_means: str, check_id: str
) -> OperatorAlternative:
    checks = (
        additional_step(dirt(X), f"{{x}} {_write_phrase_already_in_state(dirt, holds=False)}"),
        *require_interactable(X),
        replace(missing_step(cleaning_means, message_without_means), id=check_id),
    )
    return OperatorAlternative(dirt(X), checks, (Delete(dirt(X)),))


def make_soak_action() -> Operator:
    """Return the action SOAK: an object in (or on) a running sink or a teapot becomes wet."""
    vessel = (p.sink(Y) | p.teapot(Y)) & (p.is_toggled_on(Y) | ~p.toggleable(Y))
    in_water = missing_step(Exists(Y, p.carried_by(X, Y) & vessel), "{x} is in no running sink and no teapot")
    return make_action_changing_object_state(
        "SOAK", p.soakable, p.is_soaked, "make the object wet", to_true=True, last_checks=(in_water,)
    )


def make_cook_action() -> Operator:
    """Return the action COOK: an object in a saucepan becomes cooked."""
    in_pan = missing_step(Exists(Y, p.carried_by(X, Y) & p.saucepan(Y)), "{x} is in no saucepan")
    return make_action_changing_object_state(
        "COOK", p.cookable, p.is_cooked, "cook the object", to_true=True, last_checks=(in_pan,)
    )


def make_freeze_action() -> Operator:
    """Return the action FREEZE: an object in a fridge freezes."""
    in_cold = missing_step(Exists(Y, p.carried_by(X, Y) & p.cold_source(Y)), "{x} is in no fridge")
    return make_action_changing_object_state(
        "FREEZE", p.freezable, p.is_frozen, "freeze the object", to_true=True, last_checks=(in_cold,)
    )


def make_operators() -> tuple[Operator, ...]:
    """Return all actions in the order of the list in the paper's package (``EvalActions``).

    An action of the left hand comes directly before the same action of the right hand.
    """
    not_on = missing_step(~(p.toggleable(X) & p.is_toggled_on(X)), "{x} is running")
    return (
        Operator("NAVIGATE_TO", (X,), (), (), "go to the object", role=OperatorRole.MOVEMENT),
        *chain.from_iterable(zip(*map(make_hand_actions, HANDS), strict=True)),
        make_action_changing_object_state(
            "OPEN", p.openable, p.is_open, "open the object", to_true=True, last_checks=(not_on,)
        ),
        make_action_changing_object_state("CLOSE", p.openable, p.is_open, "close the object", to_true=False),
        make_cook_action(),
        make_clean_action(),
        make_freeze_action(),
        make_action_changing_object_state(
            "UNFREEZE", p.freezable, p.is_frozen, "thaw the object", to_true=False
        ),
        make_slice_action(),
        make_soak_action(),
        make_action_changing_object_state("DRY", p.soakable, p.is_soaked, "dry the object", to_true=False),
        make_toggle_on_action(),
        make_action_changing_object_state(
            "TOGGLE_OFF", p.toggleable, p.is_toggled_on, "switch the object off", to_true=False
        ),
    )


def _write_phrase_already_in_state(state: Predicate, *, holds: bool) -> str:
    words = state.name.removeprefix("is_").replace("_", " ")
    return f"is already {words}" if holds else f"is already not {words}"
