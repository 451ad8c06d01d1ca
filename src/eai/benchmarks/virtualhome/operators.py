"""The actions of VirtualHome, each with its ordered checks and its effects.

The operators follow the paper's description of the simulator (scoring rules `strict`). Their source is the
module ``execution.py`` of the paper's package. Defects of this package are listed in
`eai.extensions.reference.virtualhome_quirks`.
"""

from __future__ import annotations

import eai.logic.formula as f
from eai.benchmarks.virtualhome import predicates as p
from eai.benchmarks.virtualhome.predicates import R, X, Y
from eai.world.derived import is_a
from eai.world.effect import ANYTHING, Add, Delete, Effect, ForEach, Let, When, make_symmetric_effects
from eai.world.frame import AGENT
from eai.world.operator import Check, Operator, OperatorRole, additional_step, affordance, missing_step
from eai.world.vocabulary import Predicate

H = f.Variable("h")

SQUEEZABLE = (
    "check",
    "cleaning_solution",
    "dish_soap",
    "food_lemon",
    "food_peanut_butter",
    "paper",
    "rag",
    "shampoo",
    "soap",
    "sponge",
    "tooth_paste",
    "towel",
)
"""Classes of objects to squeeze, other than clothes (``SqueezeExecutor`` of the paper's package)."""

# The following checks are shared by several actions.
NEAR = missing_step(p.near(X), "the character is not next to {x}")
NEAR_TARGET = missing_step(p.near(Y), "the character is not next to {y}")
HELD = missing_step(p.held(X), "the character does not hold {x}")
HAND_FREE = missing_step(p.hand_free(), "the character has no free hand")
REACHABLE = missing_step(~p.shut_in(X), "{x} is inside something that is closed", witness=p.SHUT_IN)
FACED = missing_step(p.faced(X), "the character does not face {x}")
UPRIGHT = missing_step(p.upright(), "the character is sitting or lying")
SOMEWHERE = affordance(p.somewhere(X), "{x} is in no room, so there is no way to it")
OPENABLE = affordance(p.can_open(X) | is_a(X, "desk", "window"), "{x} cannot be opened or closed")
IS_CLOTHES = affordance(p.clothes(X), "{x} is not clothes")

# Checks that the paper's package does not make, or makes differently.
OPEN_OR_CLOSED = affordance(p.open_(X) | p.closed(X), "{x} is neither open nor closed: it has no such state")
ON_OR_OFF = affordance(p.on(X) | p.off(X), "{x} is neither on nor off: it has no such state")
PLUGGED_IN_OR_OUT = affordance(
    p.plugged_in(X) | p.plugged_out(X), "{x} is neither plugged in nor out: it has no such state"
)
NOT_RUNNING = missing_step(~p.on(X), "{x} is switched on")
NOT_HELD = additional_step(~p.held(X), "{x} is in a hand already")
NOT_SEATED = additional_step(~(p.sitting(AGENT) & p.ontop(AGENT, X)), "the character sits on {x} already")
NOT_IN_BED = additional_step(~(p.lying(AGENT) & p.ontop(AGENT, X)), "the character lies on {x} already")
NOT_SEATED_ELSEWHERE = missing_step(~p.sitting(AGENT), "the character sits already, but not on {x}")
NOT_IN_BED_ELSEWHERE = missing_step(~p.lying(AGENT), "the character lies already, but not on {x}")

AT_HAND = p.ontop(X, AGENT) | p.body_part(X) | p.near(X)
"""Condition that the character wears an object, is near the object, or has the object as a body part.

The action FIND does not walk to such an object.
"""


def make_action_changing_object_state(
    name: str, old_state: Predicate, new_state: Predicate, *checks: Check
) -> Operator:
    """Return an action that ends one state of an object and begins another."""
    return _make_action_on_one_object(name, *checks, effects=(Delete(old_state(X)), Add(new_state(X))))


def make_effects_of_clearing_relations(obj: f.Term, *relations: Predicate) -> tuple[Effect, ...]:
    """Return effects that end the given relations between an object and any other object."""
    return tuple(
        effect for relation in relations for effect in make_symmetric_effects(Delete, relation(obj, ANYTHING))
    )


def make_effects_of_leaving_hand(obj: f.Variable) -> tuple[Effect, ...]:
    """Return effects that remove an object from the hand that holds it."""
    return Delete(p.holds_rh(AGENT, obj)), Delete(p.holds_lh(AGENT, obj))


def make_effects_forgetting_place_grabbed_from(obj: f.Variable) -> tuple[Effect, ...]:
    """Return effects that delete the stored place from which an object was grabbed (its origin)."""
    return (
        Delete(p.taken_from_top_of(obj, ANYTHING)),
        Delete(p.taken_from_inside(obj, ANYTHING)),
        Delete(p.taken_from_next_to(obj, ANYTHING)),
    )


def make_effects_moving_held_objects(target_room: f.Formula) -> tuple[Effect, ...]:
    """Return effects that move held objects, and all objects in or on them, into a room.

    Args:
        target_room: a condition on the variable ``r``, which is true only if ``r`` is the room.
    """

    def make_effects_moving_object(moving_object: f.Variable) -> tuple[Effect, ...]:
        return (
            *make_effects_of_clearing_relations(moving_object, p.next_to, p.facing),
            ForEach(R, p.room(R) & p.inside(moving_object, R), (Delete(p.inside(moving_object, R)),)),
            *make_symmetric_effects(Add, p.next_to(AGENT, moving_object)),
            Let(R, target_room, (Add(p.inside(moving_object, R)),)),
        )

    return (
        ForEach(
            H,
            p.held(H),
            (*make_effects_moving_object(H), ForEach(Y, p.carries(H, Y), make_effects_moving_object(Y))),
        ),
        ForEach(H, p.held(H), (ForEach(Y, p.carries(H, Y), make_symmetric_effects(Add, p.next_to(H, Y))),)),
    )


def make_movement_effects(target: f.Variable, effects_on_held: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """Return effects that move the character to an object, or into a room.

    Args:
        target: the object or room.
        effects_on_held: additional effects on the held objects.
    """
    return (
        *make_effects_of_clearing_relations(AGENT, p.inside, p.next_to, p.facing),
        Let(R, p.room_of(target, R), (Add(p.inside(AGENT, R)),)),
        When(
            ~p.room(target),
            (
                ForEach(
                    Y, p.inside(target, Y) & ~p.room(Y), make_symmetric_effects(Add, p.next_to(AGENT, Y))
                ),
                ForEach(Y, p.body_part(Y), make_symmetric_effects(Add, p.next_to(AGENT, Y))),
                *make_symmetric_effects(Add, p.next_to(AGENT, target)),
            ),
        ),
        *effects_on_held,
        When(
            p.can_open(target),
            (ForEach(Y, p.inside(Y, target), make_symmetric_effects(Add, p.next_to(AGENT, Y))),),
        ),
        ForEach(Y, p.ontop(target, Y), make_symmetric_effects(Add, p.next_to(AGENT, Y))),
    )


def make_find_action(effects_on_held: tuple[Effect, ...]) -> Operator:
    """Return the action FIND.

    If the object is near, the character steps up to the object and then faces no object. Otherwise the
    character walks to the object.
    """
    checks = (
        missing_step(
            f.Implies(p.ontop(X, AGENT) | p.body_part(X), p.near(X)),
            NEAR.reason,
            history_conditions=(p.near(X),),
        ),
        missing_step(f.Or((p.upright(), AT_HAND)), UPRIGHT.reason, history_conditions=(p.upright(),)),
        affordance(f.Or((p.somewhere(X), AT_HAND)), SOMEWHERE.reason),
    )
    step_up = (Delete(p.facing(AGENT, ANYTHING)), *make_symmetric_effects(Add, p.next_to(AGENT, X)))
    return _make_action_on_one_object(
        "FIND",
        *checks,
        effects=(When(p.near(X), step_up, make_movement_effects(X, effects_on_held)),),
        role=OperatorRole.MOVEMENT,
    )


def make_put_effects(relation: Predicate) -> tuple[Effect, ...]:
    """Return effects that take an object out of the hand and relate the object to a target.

    Object and character are then next to the target.
    """
    return (
        *make_effects_of_leaving_hand(X),
        *make_symmetric_effects(Add, p.next_to(AGENT, Y)),
        *make_symmetric_effects(Add, p.next_to(X, Y)),
        Add(relation(X, Y)),
        *make_effects_forgetting_place_grabbed_from(X),
    )


ORIGINS = (
    (p.taken_from_top_of, p.lies_on, p.ontop),
    (p.taken_from_inside, p.lies_in, p.inside),
    (p.taken_from_next_to, p.lies_next_to, p.next_to),
)
"""Triples of predicates, one triple for each kind of place from which an object can be taken.

- The first predicate relates a held object to the place from which it was taken.
- The second relates an object to the place from which it would be taken now.
- The third is the relation of the scene graph that becomes true when the object is put back to the place.
"""


KEEP_CONTENTS = (
    ForEach(Y, p.inside(Y, X), (Add(p.inside(Y, X)), *make_symmetric_effects(Add, p.next_to(X, Y)))),
    ForEach(
        Y, p.ontop(Y, X) & p.grabbable(Y), (Add(p.ontop(Y, X)), *make_symmetric_effects(Add, p.next_to(X, Y)))
    ),
)
"""Effects of grabbing an object: objects in it remain in it, and grabbable objects on it remain on it."""


def make_grab_action(effects_on_contents: tuple[Effect, ...] = KEEP_CONTENTS) -> Operator:
    """Return the action GRAB: move an object to a free hand, the right hand first, and remember its origin.

    Args:
        effects_on_contents: effects on the objects that are in or on the grabbed object.
    """
    checks = (
        affordance(p.grabbable(X) | is_a(X, "water", "child"), "{x} cannot be grabbed"),
        NOT_HELD,
        NEAR,
        REACHABLE,
        HAND_FREE,
    )
    remember = tuple(
        Let(Y, lies(X, Y), (*make_symmetric_effects(Add, p.next_to(AGENT, Y)), Add(memory(X, Y))))
        for memory, lies, _ in ORIGINS
    )
    effects = (
        *make_effects_of_clearing_relations(X, p.ontop, p.inside, p.next_to, p.holds_lh, p.holds_rh),
        *effects_on_contents,
        *make_symmetric_effects(Add, p.next_to(AGENT, X)),
        When(p.right_hand_free(), (Add(p.holds_rh(AGENT, X)),), (Add(p.holds_lh(AGENT, X)),)),
        Let(R, p.room_of(AGENT, R), (Add(p.inside(X, R)),)),
        *make_effects_forgetting_place_grabbed_from(X),
        *remember,
    )
    return _make_action_on_one_object("GRAB", *checks, effects=effects, role=OperatorRole.TAKES)


def make_switch_hands_action() -> Operator:
    """Return the action SWITCH_HANDS: move a held object to the other hand.

    Only subgoals can name hands, so only subgoals need this action.
    """
    one_free = missing_step(p.right_hand_free() | p.left_hand_free(), "both hands are full")
    to_left = (Delete(p.holds_rh(AGENT, X)), Add(p.holds_lh(AGENT, X)))
    to_right = (Delete(p.holds_lh(AGENT, X)), Add(p.holds_rh(AGENT, X)))
    switched = (When(p.holds_rh(AGENT, X), to_left, to_right),)
    return _make_action_on_one_object(
        "SWITCH_HANDS", HELD, one_free, effects=switched, role=OperatorRole.RELEASES
    )


def make_put_back_action() -> Operator:
    """Return the action PUTOBJBACK: return a held object to the place from which it was grabbed."""
    closed = f.Exists(Y, p.taken_from_inside(X, Y) & p.can_open(Y) & ~p.open_(Y))
    checks = (
        missing_step(p.taken(X), "{x} was not grabbed, so it has no place to return to"),
        HELD,
        missing_step(
            f.Or(tuple(f.Exists(Y, memory(X, Y) & p.near(Y)) for memory, _, _ in ORIGINS)),
            "the character is not next to the place where {x} was taken from",
        ),
        missing_step(~closed, "the place where {x} was taken from is closed", witness=closed),
    )
    effects = tuple(Let(Y, memory(X, Y), make_put_effects(relation)) for memory, _, relation in ORIGINS)
    return _make_action_on_one_object("PUTOBJBACK", *checks, effects=effects)


def make_watch_action() -> Operator:
    """Return the action WATCH: look for a while at an object in the same room."""
    return _make_action_on_one_object(
        "WATCH",
        affordance(p.lookable(X), "{x} cannot be watched"),
        affordance(p.in_same_room(X), "{x} is not in the character's room"),
        FACED,
        missing_step(
            p.upright() | is_a(X, "computer") | p.facing(AGENT, X),
            "the character sits or lies and does not face {x}",
            history_conditions=(p.facing(AGENT, X),),
        ),
        REACHABLE,
    )


def make_push_or_pull_action(name: str, *checks: Check) -> Operator:
    """Return an action that moves an object by hand without lifting the object."""
    return _make_action_on_one_object(name, *checks, NEAR, REACHABLE, HAND_FREE)


def make_operators() -> tuple[Operator, ...]:
    """Return all actions. Each makes its checks in the order of ``execution.py`` in the paper's package."""
    return (
        *make_movement_actions(make_effects_moving_held_objects(p.room_of(X, R))),
        *_make_posture_actions(),
        *_make_object_handling_actions(),
        *_make_device_actions(),
        *_make_looking_actions(),
        *_make_consuming_and_manipulating_actions(),
        *_make_cleaning_actions(),
        *_make_clothing_actions(),
    )


def make_movement_actions(effects_on_held: tuple[Effect, ...]) -> tuple[Operator, ...]:
    """Return the actions WALK, RUN and FIND.

    Args:
        effects_on_held: effects that walking has on the held objects.
    """
    effects = make_movement_effects(X, effects_on_held)
    walks = [
        _make_action_on_one_object(name, UPRIGHT, SOMEWHERE, effects=effects, role=OperatorRole.MOVEMENT)
        for name in ("WALK", "RUN")
    ]
    return *walks, make_find_action(effects_on_held)


def _make_posture_actions() -> tuple[Operator, ...]:
    resting = missing_step(p.lying(AGENT) | p.sitting(AGENT), "the character neither lies nor sits")
    return (
        _make_action_on_one_object(
            "SIT",
            NEAR,
            NOT_SEATED,
            NOT_SEATED_ELSEWHERE,
            affordance(p.sittable(X), "{x} is nothing to sit on"),
            missing_step(~p.seat_full(X), "there is no room left on {x}"),
            effects=(
                Add(p.ontop(AGENT, X)),
                ForEach(Y, p.facing(X, Y), (Add(p.facing(AGENT, Y)),)),
                Delete(p.lying(AGENT)),
                Add(p.sitting(AGENT)),
            ),
            role=OperatorRole.MOVEMENT,
        ),
        _make_action_on_one_object(
            "LIE",
            NEAR,
            NOT_IN_BED,
            NOT_IN_BED_ELSEWHERE,
            affordance(p.lieable(X), "{x} is nothing to lie on"),
            missing_step(~p.bed_full(X), "there is no room left on {x}"),
            effects=(Add(p.ontop(AGENT, X)), Delete(p.sitting(AGENT)), Add(p.lying(AGENT))),
            role=OperatorRole.MOVEMENT,
        ),
        _make_action_without_arguments(
            "STANDUP",
            additional_step(p.sitting(AGENT) | p.lying(AGENT), "the character stands already"),
            (Delete(p.sitting(AGENT)), Delete(p.lying(AGENT))),
            OperatorRole.MOVEMENT,
        ),
        _make_action_without_arguments("SLEEP", resting),
        _make_action_without_arguments("WAKEUP", resting),
    )


def _make_object_handling_actions() -> tuple[Operator, ...]:
    drop = (
        *make_effects_of_leaving_hand(X),
        Let(R, p.room_of(AGENT, R), (Add(p.inside(X, R)),)),
        *make_effects_forgetting_place_grabbed_from(X),
    )
    return (
        make_grab_action(),
        _make_action_on_two_objects("PUTBACK", HELD, NEAR_TARGET, effects=make_put_effects(p.ontop)),
        _make_action_on_two_objects(
            "PUTIN",
            HELD,
            NEAR_TARGET,
            missing_step(~p.can_open(Y) | p.open_(Y), "{y} is closed"),
            effects=make_put_effects(p.inside),
        ),
        make_put_back_action(),
        _make_action_on_one_object("DROP", HELD, effects=drop, role=OperatorRole.RELEASES),
        _make_action_on_one_object("RELEASE", HELD, effects=drop, role=OperatorRole.RELEASES),
        _make_action_on_two_objects(
            "POUR",
            affordance(p.pourable(X) | p.drinkable(X), "{x} cannot be poured"),
            affordance(p.recipient(Y) | is_a(Y, "hands_both", "sponge", "face"), "{y} holds no liquid"),
            HELD,
            NEAR_TARGET,
            effects=(Add(p.inside(X, Y)), When(is_a(X, "water"), make_effects_of_leaving_hand(X))),
        ),
    )


def _make_device_actions() -> tuple[Operator, ...]:
    opens = (OPENABLE, OPEN_OR_CLOSED, NEAR)
    switches = (affordance(p.has_switch(X), "{x} has no switch"), ON_OR_OFF, NEAR)
    plugs = (affordance(p.has_plug(X), "{x} has no plug"), PLUGGED_IN_OR_OUT, NEAR, HAND_FREE)
    has_power = missing_step(~p.plugged_out(X), "{x} is not plugged in")
    is_closed = additional_step(p.closed(X), "{x} is not closed")
    is_unplugged = additional_step(p.plugged_out(X), "{x} is not unplugged")
    is_plugged_in = additional_step(p.plugged_in(X), "{x} is not plugged in")
    return (
        make_action_changing_object_state(
            "OPEN", p.closed, p.open_, *opens, HAND_FREE, is_closed, NOT_RUNNING
        ),
        make_action_changing_object_state(
            "CLOSE", p.open_, p.closed, *opens, additional_step(p.open_(X), "{x} is not open")
        ),
        make_action_changing_object_state(
            "SWITCHON", p.off, p.on, *switches, additional_step(p.off(X), "{x} is not off"), has_power
        ),
        make_action_changing_object_state(
            "SWITCHOFF", p.on, p.off, *switches, additional_step(p.on(X), "{x} is not on")
        ),
        make_action_changing_object_state("PLUGIN", p.plugged_out, p.plugged_in, *plugs, is_unplugged),
        make_action_changing_object_state("PLUGOUT", p.plugged_in, p.plugged_out, *plugs, is_plugged_in),
    )


def _make_looking_actions() -> tuple[Operator, ...]:
    turn = (Delete(p.facing(AGENT, ANYTHING)), Add(p.facing(AGENT, X)))
    looks = ("LOOKAT", "LOOKAT_SHORT", "LOOKAT_MEDIUM", "LOOKAT_LONG", "POINTAT")
    return (
        _make_action_on_one_object("TURNTO", effects=turn, role=OperatorRole.MOVEMENT),
        *(_make_action_on_one_object(name, FACED) for name in looks),
        make_watch_action(),
        _make_action_on_one_object("READ", affordance(p.readable(X), "{x} cannot be read"), HELD),
        _make_action_on_one_object("GREET", affordance(p.person(X), "{x} is not a person")),
    )


def _make_consuming_and_manipulating_actions() -> tuple[Operator, ...]:
    knife_in_hand = f.Exists(Y, p.held(Y) & is_a(Y, "knife"))
    can_be_moved = affordance(p.movable(X) | is_a(X, "button", "chair", "curtain"), "{x} cannot be moved")
    return (
        _make_action_on_one_object(
            "DRINK", affordance(p.drinkable(X) | p.recipient(X), "{x} is nothing to drink"), HELD
        ),
        _make_action_on_one_object(
            "EAT",
            NEAR,
            affordance(
                p.eatable(X) | f.Exists(Y, p.ontop(Y, X) & p.eatable(Y)),
                "{x} cannot be eaten, nor is there anything eatable on it",
            ),
        ),
        _make_action_on_one_object(
            "CUT",
            HAND_FREE,
            NEAR,
            affordance(p.eatable(X), "{x} cannot be eaten"),
            affordance(p.cuttable(X), "{x} cannot be cut"),
            missing_step(knife_in_hand, "the character holds no knife"),
        ),
        _make_action_on_one_object("TOUCH", NEAR, REACHABLE),
        _make_action_on_one_object(
            "TYPE", NEAR, affordance(is_a(X, "keyboard") | p.has_switch(X), "{x} is nothing to type on")
        ),
        make_push_or_pull_action("PUSH"),
        make_push_or_pull_action("PULL", can_be_moved),
        make_push_or_pull_action("MOVE", can_be_moved),
        _make_action_on_one_object(
            "SQUEEZE",
            HAND_FREE,
            NEAR,
            affordance(p.clothes(X) | is_a(X, *SQUEEZABLE), "{x} cannot be squeezed"),
        ),
    )


def _make_cleaning_actions() -> tuple[Operator, ...]:
    cleaned = (Delete(p.dirty(X)), Add(p.clean(X)))
    something_in_hand = missing_step(f.Exists(Y, p.held(Y)), "the character holds nothing to wipe with")
    return (
        *(_make_action_on_one_object(name, NEAR, effects=cleaned) for name in ("WASH", "RINSE", "SCRUB")),
        _make_action_on_one_object("WIPE", NEAR, something_in_hand, effects=cleaned),
    )


def _make_clothing_actions() -> tuple[Operator, ...]:
    return (
        _make_action_on_one_object(
            "PUTON", HELD, IS_CLOTHES, effects=(Add(p.ontop(X, AGENT)), *make_effects_of_leaving_hand(X))
        ),
        _make_action_on_one_object(
            "PUTOFF",
            missing_step(p.ontop(X, AGENT), "the character does not wear {x}"),
            IS_CLOTHES,
            effects=(Delete(p.ontop(X, AGENT)),),
        ),
    )


def _make_action_without_arguments(
    name: str, check: Check, effects: tuple[Effect, ...] = (), role: OperatorRole = OperatorRole.CHANGE
) -> Operator:
    return Operator(name, (), (check,), effects, role=role)


def _make_action_on_one_object(
    name: str, *checks: Check, effects: tuple[Effect, ...] = (), role: OperatorRole = OperatorRole.CHANGE
) -> Operator:
    return Operator(name, (X,), checks, effects, role=role)


def _make_action_on_two_objects(name: str, *checks: Check, effects: tuple[Effect, ...]) -> Operator:
    return Operator(name, (X, Y), checks, effects, role=OperatorRole.CHANGE)
