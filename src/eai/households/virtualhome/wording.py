"""The words of VirtualHome's prompts."""

from __future__ import annotations

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.households.virtualhome.domain import as_meant
from eai.households.virtualhome.tasks import PREDICATE_OF_RELATION
from eai.prompts.wording import Wording

_RELATION_NAMES = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}


def wording(ability: Ability) -> Wording:
    """As declared; but goal interpretation speaks of classes, and names relations as scene graphs do."""
    words = Wording.of(as_meant())
    if ability is not Ability.GOAL_INTERPRETATION:
        return words
    return Wording(words.domain, words.predicates, _RELATION_NAMES, _class_name)


def _class_name(task: Task, index: int) -> str:
    return task.scene.objects[index].category
