"""Translate published planning operators of VirtualHome to its household actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from eai.benchmarks.counterparts import Counterpart, translate_steps
from eai.benchmarks.virtualhome.plan_notation import VirtualHomePlanNotation
from eai.pddl.execute import PlanStep
from eai.tasks.task import Task
from eai.world.action import Action

_ACTIONS_OF_ONE_OBJECT: Mapping[str, str] = {
    "walk_towards": "WALK",
    "walk_into": "WALK",
    "find": "FIND",
    "sit": "SIT",
    "grab": "GRAB",
    "open": "OPEN",
    "close": "CLOSE",
    "put_on_character": "PUTON",
    "switch_on": "SWITCHON",
    "switch_off": "SWITCHOFF",
    "drink": "DRINK",
    "turn_to": "TURNTO",
    "look_at": "LOOKAT",
    "wipe": "WIPE",
    "drop": "DROP",
    "read": "READ",
    "touch": "TOUCH",
    "lie": "LIE",
    "type": "TYPE",
    "watch": "WATCH",
    "move": "MOVE",
    "wash": "WASH",
    "squeeze": "SQUEEZE",
    "plug_in": "PLUGIN",
    "plug_out": "PLUGOUT",
    "cut": "CUT",
    "eat": "EAT",
}
_ACTIONS_OF_TWO_OBJECTS: Mapping[str, str] = {"put_on": "PUTBACK", "put_inside": "PUTIN", "pour": "POUR"}
_ACTIONS_OF_NO_OBJECT: Mapping[str, str] = {"standup": "STANDUP", "sleep": "SLEEP", "wake_up": "WAKEUP"}

COUNTERPARTS: Mapping[str, Counterpart] = {
    **{operator: (action, ()) for operator, action in _ACTIONS_OF_NO_OBJECT.items()},
    **{operator: (action, (1,)) for operator, action in _ACTIONS_OF_ONE_OBJECT.items()},
    **{operator: (action, (1, 2)) for operator, action in _ACTIONS_OF_TWO_OBJECTS.items()},
}
"""Operator of the published planning domain -> household action, and indices of the arguments that it takes.

Argument 0 of each operator, the character, is no argument of an action.
"""


def translate_to_household_actions(task: Task, published_steps: Sequence[PlanStep]) -> tuple[Action, ...]:
    """Return the household actions for a plan in the published planning domain.

    The result ends before the first step without a household action. Plans name objects by class. As in
    answers to action sequencing, a class stands for one object of the task.
    """
    return tuple(
        translate_steps(published_steps, COUNTERPARTS, VirtualHomePlanNotation().make_object_lookup(task))
    )
