"""The BEHAVIOR domain as eai-eval 1.0.5 has it: where its simulator deviates from what it is meant to do.

Each quirk replaces checks or effects of the declaration; together they turn the declared domain into that of
`eai-1.0.5`. The engine knows nothing of them. Further quirks are in how goals are checked
(`eai.reference.behavior_goal_test`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, reduce

from typing_extensions import assert_never

from eai.households.behavior import operators as o
from eai.households.behavior import predicates as p
from eai.households.behavior.domain import as_declared
from eai.households.behavior.predicates import X, Y
from eai.logic.formula import FALSE, Exists, Formula
from eai.reference.quirk import Quirk
from eai.world.domain import Domain
from eai.world.effect import Add, Delete, Effect, ForEach, Let, When
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.operator import Check, Operator
from eai.world.state import State
from eai.world.vocabulary import Predicate

SUBGOAL_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
)
"""Which kind counts in the reference's subgoal decomposition (``checkers.py`` handle_compound_errors)."""


@cache
def as_in_reference() -> Domain:
    """The reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, as_declared())


@cache
def as_in_reference_subgoals() -> Domain:
    """The same for subgoal decomposition, where the reference ranks kinds of error differently."""
    return replace(as_in_reference(), precedence=SUBGOAL_PRECEDENCE)


def half_done(state: State, action: Action) -> State:
    """Return the state that the reference leaves when it aborts in an action (quirk `transfer_aborts`)."""
    operator = _half_done().compiled.get(action.operator)
    return state if operator is None else operator.apply(state, operator.bind(state, action.arguments))


@cache
def _half_done() -> Domain:
    return replace(as_declared(), operators=half_done_transfers())


def _each(change: Callable[[Operator], Operator]) -> Callable[[Domain], Domain]:
    """A change of the domain that is a change of each single operator."""
    return lambda domain: domain.with_operators(*map(change, domain.operators))


def _without(unwanted: tuple[Check, ...]) -> Callable[[Operator], Operator]:
    """Leave these checks out, wherever they are."""

    def kept(checks: tuple[Check, ...]) -> tuple[Check, ...]:
        return tuple(check for check in checks if check not in unwanted)

    def change(operator: Operator) -> Operator:
        tries = tuple(replace(each, checks=kept(each.checks)) for each in operator.tries)
        return replace(operator, checks=kept(operator.checks), tries=tries)

    return change


def _navigation_aborts(domain: Domain) -> Domain:
    undefined = Check(FALSE, FaultKind.UNCATEGORISED, "the reference cannot execute this action")
    return domain.with_operators(
        *(Operator(name, (X,), (undefined,), ()) for name in ("NAVIGATE_TO", "BURN"))
    )


def _other_hand_is_additional(operator: Operator) -> Operator:
    strict = [o.in_one_hand(hand) for hand in o.HANDS]

    def check(each: Check) -> Check:
        return replace(each, fault=FaultKind.ADDITIONAL_STEP) if each in strict else each

    return replace(operator, checks=tuple(map(check, operator.checks)))


def _never_a_wrong_order(operator: Operator) -> Operator:
    if not any(word in operator.name for word in ("PLACE", "TRANSFER", "CLEAN")):
        return operator
    return replace(operator, checks=tuple(replace(check, sought=(FALSE,)) for check in operator.checks))


def _released_in_mid_air(operator: Operator) -> Operator:
    if not operator.name.endswith("RELEASE"):
        return operator
    return replace(operator, effects=tuple(e for e in operator.effects if isinstance(e, Delete)))


def _inside_a_floor_aborts(operator: Operator) -> Operator:
    if o.NO_INSIDE not in operator.checks:
        return operator
    aborts = replace(o.NO_INSIDE, fault=FaultKind.UNCATEGORISED, sought=(FALSE,))
    kept = tuple(check for check in operator.checks if check != o.NO_INSIDE)
    return replace(operator, checks=(*kept, aborts) if "PLACE" in operator.name else kept)


def _transfer_aborts(operator: Operator) -> Operator:
    hand = next((hand for hand in o.HANDS if operator.name.startswith(f"{hand.name}_TRANSFER")), None)
    if hand is None:
        return operator
    aborts = Check(~_contents(hand), FaultKind.UNCATEGORISED, "the reference cannot move contents", (FALSE,))
    return replace(operator, checks=(*operator.checks, aborts), effects=())


def _contents(hand: o.Hand) -> Formula:
    """What the hand holds has something in or on it."""
    return Exists(o.H, hand.holds(o.H) & Exists(o.C, p.carries(o.H, o.C)))


def half_done_transfers() -> tuple[Operator, ...]:
    """What an aborted transfer of contents has done already: the first of them is moved."""

    def transfer(hand: o.Hand, name: str, place: Predicate) -> Operator:
        first = Exists(o.H, hand.holds(o.H) & p.carries(o.H, o.C))
        moved = Let(o.C, first & ~p.floor(X), (*o.cut_loose(o.C), Add(place(o.C, X))))
        lost = Let(o.C, first & p.floor(X), o.cut_loose(o.C))
        return Operator(f"{hand.name}_TRANSFER_CONTENTS_{name}", (X,), (), (moved, lost))

    places = (("INSIDE", p.lies_in), ("ONTOP", p.lies_on))
    return tuple(transfer(hand, name, place) for hand in o.HANDS for name, place in places)


def _one_label_per_pair(operator: Operator) -> Operator:
    return replace(operator, effects=tuple(each for e in operator.effects for each in _overwriting(e)))


def _overwriting(effect: Effect) -> tuple[Effect, ...]:
    """The effect, with which a label replaces all others of the same ordered pair."""
    match effect:
        case Add(atom):
            labels = [label.name for label in p.LABELS]
            others = labels if atom.predicate in labels else []
            deletions = (Delete(replace(atom, predicate=name)) for name in others if name != atom.predicate)
            return (*deletions, effect)
        case Delete():
            return (effect,)
        case When(condition, effects, otherwise):
            return (When(condition, _all_overwriting(effects), _all_overwriting(otherwise)),)
        case ForEach() | Let():
            return (replace(effect, effects=_all_overwriting(effect.effects)),)
        case _:
            assert_never(effect)


def _all_overwriting(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return tuple(x for effect in effects for x in _overwriting(effect))


def _freezes_anywhere(operator: Operator) -> Operator:
    return replace(operator, checks=operator.checks[:-1]) if operator.name == "FREEZE" else operator


QUIRKS: tuple[Quirk, ...] = (
    Quirk(
        "other_hand_is_additional",
        "evolving_graph.py grasp",
        "grasping what the other hand holds is an additional step, not a missing one",
        _each(_other_hand_is_additional),
    ),
    Quirk(
        "navigation_aborts",
        "eval_evolving_graph_env.py EvalGraphEnv",
        "NAVIGATE_TO and BURN are accepted, but executing them is an error of no kind",
        _navigation_aborts,
    ),
    Quirk(
        "released_in_mid_air",
        "evolving_graph.py release",
        "a released object stands on nothing",
        _each(_released_in_mid_air),
    ),
    Quirk(
        "inside_a_floor_aborts",
        "evolving_graph.py place_inside",
        "placing something inside a floor is an error of no kind",
        _each(_inside_a_floor_aborts),
    ),
    Quirk(
        "transfer_aborts",
        "evolving_graph.py pour_inside, pour_onto",
        "transferring contents is an error of no kind, except for an empty container, where it does nothing",
        _each(_transfer_aborts),
    ),
    Quirk(
        "parts_before_slicing",
        "evolving_graph.py interactivity_precond",
        "the parts of an object can be handled before it is sliced",
        _each(_without((o.cut_off(X), o.cut_off(Y)))),
    ),
    Quirk(
        "placing_never_in_wrong_order",
        "evolving_graph.py check_precondition",
        "no order test for placing, transferring, and cleaning what is not dirty",
        _each(_never_a_wrong_order),
    ),
    Quirk(
        "one_label_per_pair",
        "evolving_graph.py build_graph",
        "of onfloor, under and nextto only the last that was established holds of a pair",
        _each(_one_label_per_pair),
    ),
    Quirk(
        "freezes_anywhere",
        "evolving_graph.py freeze_unfreeze",
        "freezing needs no fridge",
        _each(_freezes_anywhere),
    ),
)
