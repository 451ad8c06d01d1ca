"""What the reference's character does for a subgoal (``state_action_translator.py``)."""

from __future__ import annotations

from collections.abc import Sequence

from eai.abilities.subgoal_decomposition.program import Found, Plan, Plans
from eai.planning.subgoal import GroundAtom
from eai.world.execution import Action
from eai.world.state import State

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


def plans_for(literal: GroundAtom) -> Plans:
    """The plans that bring about a literal in a state."""
    return lambda state: Found(plans_of_state(literal.predicate, literal.arguments, state))


def plans_to_take(action: Action) -> Plans:
    """The one plan that takes an action in a state."""
    return lambda state: Found(plans_of_action(*action, state))


def plans_of_state(predicate: str, arguments: Sequence[int], state: State) -> Sequence[Plan]:
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
        case "FACING":
            return [(find_y, Action("TURNTO", (y,)))]
        case "HOLDS_RH" | "HOLDS_LH":
            return [(find_y, Action("GRAB", (y,)))]
        case _:
            return []


def plans_of_action(action: str, arguments: Sequence[int], state: State) -> Sequence[Plan]:
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
