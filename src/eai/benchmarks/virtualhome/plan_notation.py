"""Plans in the form of VirtualHome's prompts: actions with lists of objects, by class, or by class and id.

``{"WALK": ["sofa"], "SIT": ["sofa"]}`` or ``{"WALK": ["sofa", "352"], "SIT": ["sofa", "352"]}``. The order of
keys is the order of steps, and a key may be repeated.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import starmap, zip_longest
from typing import NamedTuple

from eai.abilities.answer_schema import (
    Schema,
    make_list_schema,
    make_object_schema,
    make_text_schema,
    make_union_schema,
)
from eai.abilities.answer_text import AnswerFormat, JsonObject
from eai.abilities.notation.plan_form import (
    ACTION,
    STEP_FORM,
    StepList,
    WrittenPlan,
    WrittenStep,
    join_steps_of_items,
    make_plan_format,
    read_step_from_action_and_object_keys,
    read_steps_keyed_by_action,
)
from eai.abilities.notation.plan_lines import read_json_plan_or_action_lines, read_text_of_steps
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.verdict import Unreadable
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Scene

_STEPS = "action commands"
"""Key of the list of steps in an answer of a model whose provider enforces a JSON schema for answers.

The key has two words, because the paper's package reads a key of one word as an action.
"""


_DOTTED = re.compile(r"\w+\.\d+")


class ObjectWithId(NamedTuple):
    """An object in an answer: its class, and its id, or None if the answer gives no id after the class."""

    name: object
    id: object

    def __str__(self) -> str:
        return f"{self.name} without an id" if self.id is None else f"{self.name}_{self.id}"


class VirtualHomePlanNotation(PlanNotation):
    """The notation of plans of VirtualHome.

    An answer is a JSON object such as ``{"SIT": ["sofa"]}``, or a list of such objects. Operators may be in
    small letters. Errors of form are corrected by the repairs of `eai.abilities.answer_text`. The repair
    ``step_form`` reads other forms of a step, and ``action_lines`` reads lines of actions. If a number
    follows a class in any step, the whole answer is read with ids. A class with an id, such as ``soap.1002``,
    names any object of the scene. A class without an id names the task's relevant object of that class, or
    the last of several.
    """

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in an answer. A plan without steps is an empty object or list."""
        plan = read_steps(text, actions)
        if isinstance(plan, Unreadable) or not has_object_ids(plan):
            return plan
        return replace(plan, steps=tuple([_join_names_and_ids(step) for step in plan.steps]))

    def to_operator_name(self, word: str) -> str:
        """Return the name of an operator in capitals."""
        return word.upper()

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return a function from words of a plan to the index of the object that they name.

        A class alone names the relevant object of this class. A class and an id name any object of the scene.
        The function returns None for unknown names.
        """
        index = task.scene.index
        by_class_or_id = make_object_index_lookup(
            {task.scene.objects[i].category: i for i in task.relevant}, index
        )

        def find_scene_index_of_written_object(word: object) -> int | None:
            return index.get(word) if isinstance(word, str) and word in index else by_class_or_id(word)

        return find_scene_index_of_written_object

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Return the text of each step: ``"GRAB": ["soap", "1002"]``.

        If it has no objects, it ends in ``[ ]``, because the paper's package needs the blank.
        """
        return tuple([_format_step(action, scene) for action in plan])

    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the steps as one JSON object."""
        return "{" + ", ".join(answer_parts) + "}"

    def list_words_that_name_objects(self, task: Task) -> tuple[str, ...]:
        """Return the words that name the relevant objects: their classes and ids."""
        named = [task.scene.objects[index].name.rsplit(".", 1) for index in task.relevant]
        return tuple(dict.fromkeys([word for words in zip_longest(*named) for word in words if word]))

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """Return the schema of a list of objects with one step each.

        A single JSON object could not have two steps with one action, because its keys would be equal.
        """
        steps = [
            make_object_schema(
                {operator.name: make_list_schema(make_text_schema(words if operator.arity else None))}
            )
            for operator in domain.operators
        ]
        return make_object_schema({_STEPS: make_list_schema(make_union_schema(steps))})


def make_object_index_lookup(
    index_by_class: Mapping[str, int], index_by_name: Mapping[str, int], class_id_separator: str = "."
) -> Callable[[object], int | None]:
    """Return the function that finds the index of an object by its class, or by its class and id.

    It returns None for unknown names.

    Args:
        index_by_class: class -> index of the object that the class means.
        index_by_name: name of an object -> its index.
        class_id_separator: text between class and id in names of objects.
    """

    def find_object_of_word(word: object) -> int | None:
        if isinstance(word, str):
            return index_by_class.get(word)
        if isinstance(word, ObjectWithId):
            return index_by_name.get(f"{word.name}{class_id_separator}{word.id}")
        return None

    return find_object_of_word


def _join_names_and_ids(step: WrittenStep) -> WrittenStep:
    """Return a step in which each class and its id are joined to one object. ``soap.1002`` stays as it is."""
    if any(isinstance(word, str) and _DOTTED.fullmatch(word) for word in step.objects):
        objects: list[object] = []
        words = list(step.objects)
        while words:
            word = words.pop(0)
            is_whole = isinstance(word, str) and _DOTTED.fullmatch(word) is not None
            has_id = not is_whole and bool(words) and _is_numeric_id(words[0])
            objects.append(ObjectWithId(word, words.pop(0)) if has_id else word)
        return step._replace(objects=tuple(objects))
    return step._replace(objects=_pair_classes_with_ids(step.objects))


def has_object_ids(plan: WrittenPlan) -> bool:
    """Whether a plan names objects by class and id: in some step, a number follows a class."""
    return any(_is_numeric_id(word) for step in plan.steps for word in step.objects[1::2])


def join_object_classes_and_ids_in_plan(plan: WrittenPlan) -> WrittenPlan:
    """Return a copy of the plan in which each class and its id are joined to one object."""
    steps = [WrittenStep(step.action, _pair_classes_with_ids(step.objects)) for step in plan.steps]
    return replace(plan, steps=tuple(steps))


def _pair_classes_with_ids(words: tuple[object, ...]) -> tuple[ObjectWithId, ...]:
    return tuple(starmap(ObjectWithId, zip_longest(words[::2], words[1::2])))


def _is_numeric_id(word: object) -> bool:
    return isinstance(word, int) or (isinstance(word, str) and word.isdigit())


def read_steps(text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
    """Return the steps as an answer writes them, or the reason why the answer cannot be read."""
    return read_json_plan_or_action_lines(text, _build_plan_format(frozenset(actions)), actions)


@lru_cache(64)
def _build_plan_format(actions: frozenset[str]) -> AnswerFormat[StepList]:
    accepted_words = frozenset([*actions, *[action.lower() for action in actions]])

    def read_steps_in_text(text: str) -> StepList | None:
        return read_text_of_steps(text, accepted_words)

    def read_step_list(value: object) -> StepList | None:
        if isinstance(value, list):
            return join_steps_of_items(value, read_step_list)
        if not isinstance(value, JsonObject):
            return None
        if value.members == ((_STEPS, []),):
            return StepList(())
        if any(key == ACTION and isinstance(member, str) for key, member in value.members):
            step = read_step_from_action_and_object_keys(value)
            return None if step is None else step._replace(repairs=(STEP_FORM,))
        if any(
            key not in accepted_words and _is_list_of_texts_with_steps(member, read_steps_in_text)
            for key, member in value.members
        ):
            return None
        return read_steps_keyed_by_action(value, accepted_words)

    return make_plan_format(
        "object or list of actions with their objects",
        read_step_list,
        accepted_words,
        _STEPS,
        read_steps_in_text,
    )


def _is_list_of_texts_with_steps(value: object, read_steps_in_text: Callable[[str], StepList | None]) -> bool:
    """Whether a JSON value is a list of strings with steps, such as ``WALK(soap)``."""
    return (
        isinstance(value, list)
        and len(value) > 0
        and all(isinstance(item, str) and read_steps_in_text(item) is not None for item in value)
    )


def _format_step(action: Action, scene: Scene) -> str:
    words = [word for i in action.arguments for word in scene.objects[i].name.rsplit(".", 1)]
    return f"{json.dumps(action.operator)}: {json.dumps(words) if words else '[ ]'}"
