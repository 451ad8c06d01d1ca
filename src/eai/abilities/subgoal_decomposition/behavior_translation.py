"""From a BEHAVIOR subgoal to actions, given what the hands hold (``state_action_translator.py``)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.benchmarks.behavior import predicates as p
from eai.logic.formula import Atom, Formula, Not, Occurs
from eai.world.execution import Action
from eai.world.state import Scene, State

Plan = tuple[Action, ...]

_PLACING: Mapping[str, str] = {
    "inside": "PLACE_INSIDE",
    "ontop": "PLACE_ONTOP",
    "onfloor": "PLACE_ONTOP",
    "nextto": "PLACE_NEXTTO",
    "touching": "PLACE_NEXTTO",
    "under": "PLACE_UNDER",
}
_ACHIEVING: Mapping[str, str] = {
    "cooked": "COOK",
    "burnt": "COOK",
    "frozen": "FREEZE",
    "open": "OPEN",
    "sliced": "SLICE",
    "soaked": "SOAK",
    "toggledon": "TOGGLE_ON",
}
_UNDOING: Mapping[str, str] = {
    "dusty": "CLEAN",
    "stained": "CLEAN",
    "frozen": "UNFREEZE",
    "open": "CLOSE",
    "toggledon": "TOGGLE_OFF",
}
_SUPPORTING = ("ontop", "onfloor")
_NEIGHBOURING = ("nextto", "touching")
_HOLDING: Mapping[str, str] = {"holds_rh": "RIGHT", "holds_lh": "LEFT"}


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


def is_brought_about(literal: Formula) -> bool:
    """Whether there are actions for a literal at all."""
    match literal:
        case Atom(predicate):
            return predicate in _PLACING or predicate in _HOLDING or predicate in _ACHIEVING
        case Not(Atom(predicate)):
            return predicate == "inside" or predicate in _HOLDING or predicate in _UNDOING
        case _:
            return False


def are_placed_together(*subgoals: Formula) -> bool:
    """Whether these are two subgoals that put one object onto something and next to something."""
    return len(subgoals) == 2 and _together(*subgoals) is not None


def _together(first: Formula, second: Formula) -> tuple[Atom, Atom] | None:
    """The two subgoals, what supports the object and what is next to it."""
    if not isinstance(first, Atom) or not isinstance(second, Atom):
        return None
    if first.predicate in _SUPPORTING and second.predicate in _NEIGHBOURING:
        on, by = first, second
    elif first.predicate in _NEIGHBOURING and second.predicate in _SUPPORTING:
        on, by = second, first
    else:
        return None
    return (on, by) if on.arguments[0] in by.arguments else None


class Translation:
    """Translates the subgoals of one task.

    Args:
        scene: the objects.
        objects: what they are called in subgoals.
        by_substring: Quirk: a hand counts as holding an object whose name is part of the name of what it
            holds, such as ``rag_1`` of ``rag_10``.
    """

    def __init__(self, scene: Scene, objects: Mapping[str, int], *, by_substring: bool) -> None:
        self._scene = scene
        self._objects = objects
        self._by_substring = by_substring

    def plan(self, subgoal: Formula, state: State) -> Plan | None:
        """The actions for a literal or an action; None if none brings it about."""
        hands = held(state)
        match subgoal:
            case Atom(predicate):
                return self._achieve(predicate, self._indices(subgoal), hands)
            case Not(Atom(predicate) as atom):
                return self._undo(predicate, self._indices(atom), hands)
            case _:
                return None

    def plan_together(self, first: Formula, second: Formula, state: State) -> Plan | None:
        """The actions for two subgoals of which `are_placed_together` is true."""
        pair = _together(first, second)
        if pair is None:
            return None
        (thing, support), (one, other) = (self._indices(atom) for atom in pair)
        neighbour = one if thing == other else other
        actions, hand = self._take(thing, held(state))
        return (*actions, Action(f"{hand}_PLACE_NEXTTO_ONTOP", (neighbour, support)))

    def action(self, subgoal: Occurs) -> Action:
        """The action that an action subgoal asks for."""
        return Action(subgoal.action.upper(), self._indices(subgoal))

    def _indices(self, part: Atom | Occurs) -> tuple[int, ...]:
        return tuple([self._objects[term.name] for term in part.arguments])

    def _achieve(self, predicate: str, arguments: tuple[int, ...], hands: Held) -> Plan | None:
        if predicate in _PLACING:
            thing, place = arguments
            actions, hand = self._take(thing, hands)
            return (*actions, Action(f"{hand}_{_PLACING[predicate]}", (place,)))
        if predicate in _HOLDING:
            hand = _HOLDING[predicate]
            return (*_emptied(hand, hands), Action(f"{hand}_GRASP", arguments))
        if predicate in _ACHIEVING:
            return (*_one_free(hands), Action(_ACHIEVING[predicate], arguments))
        return None

    def _undo(self, predicate: str, arguments: tuple[int, ...], hands: Held) -> Plan | None:
        if predicate == "inside":
            actions, _ = self._take(arguments[0], hands)
            return (*actions, Action("RIGHT_RELEASE", arguments[:1]))
        if predicate in _HOLDING:
            hand = _HOLDING[predicate]
            return _emptied(hand, hands) if self._hand_with(arguments[0], hands) == hand else ()
        if predicate in _UNDOING:
            return (*_one_free(hands), Action(_UNDOING[predicate], arguments))
        return None

    def _take(self, thing: int, hands: Held) -> tuple[Plan, str]:
        """The actions after which a hand holds the object, and which: the right one if both are free."""
        hand = self._hand_with(thing, hands)
        if hand is not None:
            return (), hand
        if hands.right is None:
            return (Action("RIGHT_GRASP", (thing,)),), "RIGHT"
        if hands.left is None:
            return (Action("LEFT_GRASP", (thing,)),), "LEFT"
        return (*_emptied("RIGHT", hands), Action("RIGHT_GRASP", (thing,))), "RIGHT"

    def _hand_with(self, thing: int, hands: Held) -> str | None:
        return next((hand for hand in ("LEFT", "RIGHT") if self._holds(hands.in_hand(hand), thing)), None)

    def _holds(self, content: int | None, thing: int) -> bool:
        if content is None or not self._by_substring:
            return content == thing
        names = self._scene.objects
        return names[thing].name in names[content].name


def _emptied(hand: str, hands: Held) -> Plan:
    content = hands.in_hand(hand)
    return () if content is None else (Action(f"{hand}_RELEASE", (content,)),)


def _one_free(hands: Held) -> Plan:
    """The actions after which at least one hand is free."""
    return () if hands.left is None or hands.right is None else _emptied("RIGHT", hands)
