"""What the character does for a subgoal (reference: ``subgoal_decomposition/state_action_translator.py``)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.subgoal_decomposition.translation import Plans, Translation
from eai.abilities.task import Task
from eai.planning.subgoal import GroundAtom
from eai.world.execution import Action
from eai.world.state import Scene, State

BROUGHT_ABOUT_BY = {
    "CLOSED": ("CLOSE",),
    "OPEN": ("OPEN",),
    "ON": ("SWITCHON",),
    "OFF": ("SWITCHOFF",),
    "PLUGGED_IN": ("PLUGIN",),
    "PLUGGED_OUT": ("PLUGOUT",),
    "CLEAN": ("WIPE", "WASH"),
}
"""For each state of an object the actions that lead to it. Any other state is brought about by no action."""

OPPOSITES = {
    "OPEN": "CLOSED",
    "CLOSED": "OPEN",
    "ON": "OFF",
    "OFF": "ON",
    "PLUGGED_IN": "PLUGGED_OUT",
    "PLUGGED_OUT": "PLUGGED_IN",
    "DIRTY": "CLEAN",
}
"""What an object is if it is not in a state: a negated subgoal asks for that."""

NEED_THE_OBJECT_IN_HAND = frozenset({"DRINK", "EAT", "READ"})
NEED_A_LOOK = frozenset({"LOOKAT", "WATCH"})

_RELATIONS = frozenset({"ONTOP", "INSIDE", "FACING", "HOLDS_RH", "HOLDS_LH"})


@dataclass(frozen=True, slots=True)
class VirtualHomeTranslation(Translation):
    """The plans for each kind of subgoal.

    Attributes:
        either_way: whether an object's being next to the character is brought about as the character's being
            next to it; the reference does nothing for it.
    """

    either_way: bool = True

    def brings_about(self, literal: GroundAtom, scene: Scene) -> bool:
        """Whether the table has an entry."""
        predicate, arguments, truth = literal
        if not truth:
            return predicate in OPPOSITES
        if len(arguments) == 1:
            return predicate in BROUGHT_ABOUT_BY
        if predicate == "NEXT_TO":
            return scene.agent in (arguments if self.either_way else arguments[:1])
        return predicate in _RELATIONS

    def plans(self, literals: Sequence[GroundAtom], task: Task) -> Plans:
        """The plans for the one literal; for one that shall not hold none if it does not."""
        ((predicate, arguments, truth),) = literals
        if truth:
            return partial(self.of_state, predicate, arguments)
        opposite = partial(self.of_state, OPPOSITES[predicate], arguments)
        return lambda state: opposite(state) if state.has(predicate, *arguments) else ()

    def plans_to_take(self, action: Action, task: Task) -> Plans:
        """The one plan that takes an action."""
        return partial(self.of_action, *action)

    def of_state(self, predicate: str, arguments: Sequence[int], state: State) -> Sequence[Plan]:
        """The plans that bring about an atom; none if no action does."""
        if len(arguments) == 1:
            (x,) = arguments
            return [
                (Action("FIND", (x,)), Action(action, (x,))) for action in BROUGHT_ABOUT_BY.get(predicate, ())
            ]
        x, y = arguments
        agent = state.scene.agent
        find_y = Action("FIND", (y,))
        match predicate:
            case "ONTOP" if x == agent:
                return [(find_y, Action("SIT", (y,))), (find_y, Action("LIE", (y,)))]
            case "ONTOP" if y == agent:
                return [(Action("PUTON", (x,)),)]
            case "ONTOP":
                return [(*_fetch(x, state), find_y, Action("PUTBACK", (x, y)))]
            case "INSIDE" if x == agent:
                return [(Action("WALK", (y,)),)]
            case "INSIDE":
                fetch = _fetch(x, state)
                return [(*fetch, find_y, Action(action, (x, y))) for action in ("PUTIN", "POUR")]
            case "NEXT_TO" if x == agent:
                return [(find_y,)]
            case "NEXT_TO" if y == agent and self.either_way:
                return [(Action("FIND", (x,)),)]
            case "FACING":
                return [(find_y, Action("TURNTO", (y,)))]
            case "HOLDS_RH" | "HOLDS_LH":
                return [(find_y, Action("GRAB", (y,)))]
            case _:
                return []

    def of_action(self, action: str, arguments: Sequence[int], state: State) -> Sequence[Plan]:
        """The one plan that takes an action."""
        act = Action(action, tuple(arguments))
        if not arguments:
            return [(act,)]
        x, *others = arguments
        if action in NEED_A_LOOK:
            return [(Action("FIND", (x,)), Action("TURNTO", (x,)), act)]
        if others:
            return [(*_fetch(x, state), *(Action("FIND", (y,)) for y in others), act)]
        if action in NEED_THE_OBJECT_IN_HAND and not _is_held(x, state):
            return [(*_fetch(x, state), act)]
        return [(Action("FIND", (x,)), act)]


def _fetch(thing: int, state: State) -> Plan:
    if _is_held(thing, state):
        return ()
    return Action("FIND", (thing,)), Action("GRAB", (thing,))


def _is_held(thing: int, state: State) -> bool:
    agent = state.scene.agent
    if agent is None:
        return False
    return state.has("HOLDS_RH", agent, thing) or state.has("HOLDS_LH", agent, thing)
