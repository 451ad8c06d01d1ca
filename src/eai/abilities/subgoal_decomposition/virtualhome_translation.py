"""What the character does for a subgoal (reference: ``subgoal_decomposition/state_action_translator.py``)."""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.subgoal_decomposition.program import Plan
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

NEED_THE_OBJECT_IN_HAND = frozenset({"DRINK", "EAT", "READ"})
NEED_A_LOOK = frozenset({"LOOKAT", "WATCH"})


class Translation:
    """The plans for the subgoals of one scene.

    Args:
        scene: the scene.
        either_way: whether an object's being next to the character is brought about as the character's being
            next to it; the reference does nothing for it.
    """

    def __init__(self, scene: Scene, *, either_way: bool = True) -> None:
        self._agent = scene.agent
        self._either_way = either_way

    def of_state(self, predicate: str, arguments: Sequence[int], state: State) -> Sequence[Plan]:
        """The plans that bring about an atom; none if no action does."""
        if len(arguments) == 1:
            (x,) = arguments
            return [
                (Action("FIND", (x,)), Action(action, (x,))) for action in BROUGHT_ABOUT_BY.get(predicate, ())
            ]
        x, y = arguments
        find_y = Action("FIND", (y,))
        match predicate:
            case "ONTOP" if x == self._agent:
                return [(find_y, Action("SIT", (y,))), (find_y, Action("LIE", (y,)))]
            case "ONTOP" if y == self._agent:
                return [(Action("PUTON", (x,)),)]
            case "ONTOP":
                return [(*self._fetch(x, state), find_y, Action("PUTBACK", (x, y)))]
            case "INSIDE" if x == self._agent:
                return [(Action("WALK", (y,)),)]
            case "INSIDE":
                fetch = self._fetch(x, state)
                return [(*fetch, find_y, Action(action, (x, y))) for action in ("PUTIN", "POUR")]
            case "NEXT_TO" if x == self._agent:
                return [(find_y,)]
            case "NEXT_TO" if y == self._agent and self._either_way:
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
            return [(*self._fetch(x, state), *(Action("FIND", (y,)) for y in others), act)]
        if action in NEED_THE_OBJECT_IN_HAND and not self._is_held(x, state):
            return [(*self._fetch(x, state), act)]
        return [(Action("FIND", (x,)), act)]

    def _fetch(self, thing: int, state: State) -> Plan:
        if self._is_held(thing, state):
            return ()
        return Action("FIND", (thing,)), Action("GRAB", (thing,))

    def _is_held(self, thing: int, state: State) -> bool:
        if self._agent is None:
            return False
        return state.has("HOLDS_RH", self._agent, thing) or state.has("HOLDS_LH", self._agent, thing)
