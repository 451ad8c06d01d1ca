"""What the reference's robot does for a subgoal, given what the hands hold (``state_action_translator.py``).

Quirk: a hand counts as holding an object whose name is part of the name of what it holds, such as ``rag_1``
of ``rag_10``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from eai.abilities.subgoal_decomposition.program import Found, Plan, Plans
from eai.households.behavior import predicates as p
from eai.planning.subgoal import GroundAtom
from eai.world.execution import Action
from eai.world.state import Scene, State

_PLACING: Mapping[str, str] = {
    "inside": "PLACE_INSIDE",
    "ontop": "PLACE_ONTOP",
    "onfloor": "PLACE_ONTOP",
    "nextto": "PLACE_NEXTTO",
    "under": "PLACE_UNDER",
}
_ACHIEVING: Mapping[str, str] = {
    "cooked": "COOK",
    "burnt": "COOK",
    "frozen": "FREEZE",
    "open": "OPEN",
    "sliced": "SLICE",
    "soaked": "SOAK",
    "toggled_on": "TOGGLE_ON",
}
_UNDOING: Mapping[str, str] = {
    "dusty": "CLEAN",
    "stained": "CLEAN",
    "frozen": "UNFREEZE",
    "open": "CLOSE",
    "toggled_on": "TOGGLE_OFF",
}
_SUPPORTING = ("ontop", "onfloor")
_HOLDING: Mapping[str, str] = {p.in_right_hand.name: "RIGHT", p.in_left_hand.name: "LEFT"}


@dataclass(frozen=True, slots=True)
class Held:
    """The objects in the hands, by index."""

    left: int | None
    right: int | None

    def in_hand(self, hand: str) -> int | None:
        """What is in a hand, ``LEFT`` or ``RIGHT``."""
        return self.left if hand == "LEFT" else self.right


def held(state: State) -> Held:
    """What the hands hold in a state."""
    left, right = state.those(p.in_left_hand.name), state.those(p.in_right_hand.name)
    return Held(*(mask.bit_length() - 1 if mask else None for mask in (left, right)))


def are_done_together(first: GroundAtom, second: GroundAtom) -> bool:
    """Whether these put one object onto something and next to something."""
    return _together(first, second) is not None


def plans_for(literals: Sequence[GroundAtom]) -> Plans:
    """The plan for a literal, or for two that are done together; none if no action brings it about."""

    def plans(state: State) -> Found:
        first, *rest = literals
        plan = _place_together(first, rest[0], state) if rest else _plan(first, state)
        return Found(() if plan is None else (plan,))

    return plans


def _plan(literal: GroundAtom, state: State) -> Plan | None:
    predicate, arguments, truth = literal
    return (_achieve if truth else _undo)(predicate, arguments, held(state), state.scene)


def _place_together(first: GroundAtom, second: GroundAtom, state: State) -> Plan | None:
    pair = _together(first, second)
    if pair is None:
        return None
    (thing, support), (one, other) = (each.arguments for each in pair)
    neighbour = one if thing == other else other
    actions, hand = _take(thing, held(state), state.scene)
    return (*actions, Action(f"{hand}_PLACE_NEXTTO_ONTOP", (neighbour, support)))


def _achieve(predicate: str, arguments: tuple[int, ...], hands: Held, scene: Scene) -> Plan | None:
    if predicate in _PLACING:
        thing, place = arguments
        actions, hand = _take(thing, hands, scene)
        return (*actions, Action(f"{hand}_{_PLACING[predicate]}", (place,)))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return (*_emptied(hand, hands), Action(f"{hand}_GRASP", arguments))
    if predicate in _ACHIEVING:
        return (*_one_free(hands), Action(_ACHIEVING[predicate], arguments))
    return None


def _undo(predicate: str, arguments: tuple[int, ...], hands: Held, scene: Scene) -> Plan | None:
    if predicate == "inside":
        actions, _ = _take(arguments[0], hands, scene)
        return (*actions, Action("RIGHT_RELEASE", arguments[:1]))
    if predicate in _HOLDING:
        hand = _HOLDING[predicate]
        return _emptied(hand, hands) if _hand_with(arguments[0], hands, scene) == hand else ()
    if predicate in _UNDOING:
        return (*_one_free(hands), Action(_UNDOING[predicate], arguments))
    return None


def _take(thing: int, hands: Held, scene: Scene) -> tuple[Plan, str]:
    """The actions after which a hand holds the object, and which: the right one if both are free."""
    hand = _hand_with(thing, hands, scene)
    if hand is not None:
        return (), hand
    if hands.right is None:
        return (Action("RIGHT_GRASP", (thing,)),), "RIGHT"
    if hands.left is None:
        return (Action("LEFT_GRASP", (thing,)),), "LEFT"
    return (*_emptied("RIGHT", hands), Action("RIGHT_GRASP", (thing,))), "RIGHT"


def _hand_with(thing: int, hands: Held, scene: Scene) -> str | None:
    found = (hand for hand in ("LEFT", "RIGHT") if _holds(hands.in_hand(hand), thing, scene))
    return next(found, None)


def _holds(content: int | None, thing: int, scene: Scene) -> bool:
    return content is not None and scene.objects[thing].name in scene.objects[content].name


def _together(first: GroundAtom, second: GroundAtom) -> tuple[GroundAtom, GroundAtom] | None:
    """Two literals that are done together: what supports the object, then what is next to it."""
    if not first.truth or not second.truth:
        return None
    if first.predicate in _SUPPORTING and second.predicate == "nextto":
        on, by = first, second
    elif first.predicate == "nextto" and second.predicate in _SUPPORTING:
        on, by = second, first
    else:
        return None
    return (on, by) if on.arguments[0] in by.arguments else None


def _emptied(hand: str, hands: Held) -> Plan:
    content = hands.in_hand(hand)
    return () if content is None else (Action(f"{hand}_RELEASE", (content,)),)


def _one_free(hands: Held) -> Plan:
    """The actions after which at least one hand is free."""
    return () if hands.left is None or hands.right is None else _emptied("RIGHT", hands)
