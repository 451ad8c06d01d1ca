"""The words of BEHAVIOR's prompts: goals are made of what is seen of objects, not of how states store it."""

from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.households.behavior.domain import as_meant
from eai.households.behavior.predicates import GOAL_RELATIONS, GOAL_STATES
from eai.households.behavior.tasks import BehaviorTask
from eai.prompts.wording import ObjectName, Wording, declared_name

_GOAL_PREDICATES = (*(state.name for state in GOAL_STATES), *(each.name for each in GOAL_RELATIONS))
_HANDS = {"in_right_hand": "holds_rh", "in_left_hand": "holds_lh"}


def wording(ability: Ability) -> Wording:
    """The words for an ability: subgoals also speak of hands, goal interpretation names instances."""
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        written_as = {**_HANDS, "toggled_on": "toggledon"}
        return Wording(as_meant(), (*_GOAL_PREDICATES, *_HANDS), written_as, _dotted_name)
    names: ObjectName = _instance_name if ability is Ability.GOAL_INTERPRETATION else declared_name
    return Wording(as_meant(), _GOAL_PREDICATES, {}, names)


def _dotted_name(task: Task, index: int) -> str:
    """``rag_51`` as subgoals write it: ``rag.51``."""
    return ".".join(declared_name(task, index).rsplit("_", 1))


def _instance_name(task: Task, index: int) -> str:
    """The name of an object in its problem file: ``rag.n.01_1``."""
    name = declared_name(task, index)
    if not isinstance(task, BehaviorTask):
        return name
    return next((thing.instance for thing in task.record.objects if thing.name == name), name)
