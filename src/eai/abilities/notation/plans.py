"""Notations of plans: the form of plans in a benchmark's answers, and the meaning of names in them.

A written plan may contain unknown names. `resolve_plan` translates it into actions on objects. An
`Execution` is the outcome of the plan; other plans may have been executed earlier in the same world, and
actions may slip (have no effect).
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from eai.abilities.answer_schema import (
    Schema,
    make_list_schema,
    make_object_schema,
    make_text_schema,
    make_union_schema,
)
from eai.abilities.answer_text import MAX_ANSWER_CHARACTERS, AnswerFormat, JsonObject
from eai.abilities.notation.plan_form import (
    STEP_FORM,
    StepList,
    WrittenPlan,
    WrittenStep,
    correct_action_spelling,
    make_plan_format,
    read_step_from_action_and_object_keys,
    read_steps_keyed_by_action,
)
from eai.abilities.notation.plan_lines import (
    looks_like_json,
    read_json_plan_or_action_lines,
    read_plan_lines,
    read_text_of_steps,
)
from eai.abilities.verdict import UNKNOWN_ACTION, ErrorReport, Unreadable
from eai.base.grouping import group_pairs
from eai.logic.signature import describe_wrong_arity
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory
from eai.world.fault import FaultKind
from eai.world.state import Scene

ObjectLookup: TypeAlias = Callable[[object], int | None]
"""Function that finds the object that a JSON value in a step of an answer names.

It returns the object's index in the scene, or None if the value names no object.
"""


def resolve_plan(
    plan: WrittenPlan,
    domain: Domain,
    notation: PlanNotation,
    object_of: ObjectLookup,
    unknown_prefix: str = "there is no",
) -> tuple[Action, ...] | ErrorReport:
    """Return the actions on objects that a written plan means, or the first error in its names.

    Unknown names are reported before wrong numbers of arguments.

    Args:
        plan: the plan.
        domain: the domain of the operators.
        notation: the notation with the names of operators.
        object_of: returns the index of the object that a name means, or None.
        unknown_prefix: words of the error message before a name that means no object.
    """
    arities, operator_of = domain.operator_arities, notation.to_operator_name
    actions = []
    misapplied = None
    for number, (word, names) in enumerate(plan.steps):
        operator = operator_of(word)
        arity = arities.get(operator)
        if arity is None:
            return ErrorReport(FaultKind.HALLUCINATION, number, f"{word} is not an action", UNKNOWN_ACTION)
        objects = tuple([index for index in map(object_of, names) if index is not None])
        if len(objects) != len(names):
            name = next(name for name in names if object_of(name) is None)
            detail = f"{word}: {unknown_prefix} {name}"
            return ErrorReport(FaultKind.HALLUCINATION, number, detail, "unknown_object", (str(name),))
        if misapplied is None and len(objects) != arity:
            detail = describe_wrong_arity(operator, arity, "object", len(objects))
            misapplied = ErrorReport(FaultKind.ARGUMENT_NUMBER, number, detail, "wrong_arity")
        actions.append(Action(operator, objects))
    return misapplied or tuple(actions)


class Execution(NamedTuple):
    """The outcome of an executed plan.

    Attributes:
        trajectory: the trajectory of this plan alone, from the state in which it began.
        whole_trajectory: the trajectory since the beginning of this world.
        slipped: whether the plan ended because an action slipped (had no effect).
    """

    trajectory: Trajectory
    whole_trajectory: Trajectory
    slipped: bool = False

    @property
    def names_of_all_executed_actions(self) -> list[str]:
        """Names of all actions that were executed in this world."""
        return [action.operator for action in self.whole_trajectory.executed_actions]


PlanExecutor: TypeAlias = Callable[[tuple[Action, ...]], Execution]
"""Function that executes a plan from the present state of a world. An empty plan changes nothing."""


_SPECIAL = re.compile(r"[\\^$.|?*+()\[\]{}/]")
_STEP = re.compile(r"(?:[\d.]+\s*:\s*)?\(\s*([^\s()\[\]{}\"][^()\[\]{}\"]*)\)\s*(?:\[[\d.]*\])?")


class PlanNotation(ABC):
    """Reads and writes a benchmark's plans, and translates between the names in answers and in the domain."""

    @abstractmethod
    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in an answer, or the reason why the answer cannot be read.

        `eai.abilities.answer_text.read_json` says which of several plans in JSON counts.

        Args:
            text: the answer.
            actions: names of actions in answers; empty if they are unknown. A text outside the plan that has
                such a name may be a step, and then the answer cannot be read.
        """

    def to_operator_name(self, word: str) -> str:
        """Return the name of the operator that a word means. An unknown word is returned unchanged."""
        return word

    @abstractmethod
    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return the function that finds objects of a task.

        It takes the JSON value by which a step names an object, and returns the object's index or None.
        """

    @abstractmethod
    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Return the text of each step of a plan. `join` combines the texts to one answer."""

    @abstractmethod
    def join(self, answer_parts: Iterable[str]) -> str:
        """Return the texts of steps as one answer."""

    def replace_domain_names_by_answer_words(self, text: str) -> str:
        """Return a text with the words of answers in place of the domain's names."""
        return text

    def replace_answer_words_by_domain_names(self, text: str) -> str:
        """Return a text with the domain's names in place of the words of answers."""
        return text

    def write_command(self, operator: str, object_names: Sequence[str]) -> str:
        """Return an action on objects with the given names as an agent's command, such as ``OPEN(jar_0)``."""
        return f"{operator}({', '.join(object_names)})"

    def list_words_that_name_objects(self, task: Task) -> tuple[str, ...]:
        """Return the words for objects in questions about a task, each once; empty if they are unknown."""
        return ()

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """Return the JSON schema of an answer for providers that enforce schemas, or None for no schema.

        Args:
            domain: the domain of the actions.
            words: words that may name objects; None if any text is allowed.
        """
        return None


class JsonPlanNotation(PlanNotation):
    """The default notation of plans: a JSON list of steps.

    Each step has an action and the names of its objects.

    A step is ``{"action": "OPEN", "object": "jar_0"}``. Two objects are separated by a comma or stand in a
    list. An empty text stands for no object.

    Answers in other forms are repaired. The names of repairs are those of `eai.abilities.answer_text`, and
    three others: ``step_form`` for a step such as ``{"OPEN": ["jar_0"]}``, ``action_lines`` for texts such as
    ``"OPEN(jar_0)"``, and ``letter_case`` for ``open`` instead of ``OPEN``.
    """

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in an answer. A plan without steps is an empty list."""
        plan = read_json_plan_or_action_lines(text, _make_json_plan_format(frozenset(actions)), actions)
        if isinstance(plan, Unreadable):
            return plan
        return correct_action_spelling(plan, actions, self.to_operator_name)

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return the function that finds objects by their names in the scene; None for unknown names.

        ``jar.0`` means ``jar_0``, because subgoals use the dot.
        """
        index = task.scene.index

        def find_object(word: object) -> int | None:
            if not isinstance(word, str):
                return None
            return index[word] if word in index else index.get("_".join(word.rsplit(".", 1)))

        return find_object

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Return each step as ``{"action": "OPEN", "object": "jar_0"}``."""
        return tuple([_write_step(action, scene) for action in plan])

    def join(self, answer_parts: Iterable[str]) -> str:
        """Join the texts of single steps to the text of a plan, a JSON list."""
        return "[" + ", ".join(answer_parts) + "]"

    def list_words_that_name_objects(self, task: Task) -> tuple[str, ...]:
        """Return the names of the objects that matter to the task."""
        return tuple([task.scene.objects[index].name for index in task.relevant])

    def make_json_schema_of_answer(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """Return the schema of an object that holds the list of steps, since providers require an object.

        A subclass returns None if no schema describes its answers.
        """
        names = group_pairs((operator.arity, operator.name) for operator in domain.operators)
        steps = [
            make_object_schema(
                {"action": make_text_schema(names[n]), "object": _make_objects_schema(n, words)}
            )
            for n in sorted(names)
        ]
        return make_object_schema({"plan": make_list_schema(make_union_schema(steps))})


class PddlPlanNotation(JsonPlanNotation):
    """A notation that reads plans in JSON, and plans with one step a line as planners write them.

    Upper and lower case do not matter in names. A line is ``(pick ball1 rooma left) ; cost 1``. Comments,
    numbers and times before a step, and a duration in brackets after it are ignored. A line between steps
    that is not a step makes the answer unreadable.
    """

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Return the plan in the JSON of an answer, or in its lines if it has no JSON with steps."""
        lines = None
        if len(text) <= MAX_ANSWER_CHARACTERS:
            lines = read_plan_lines(text, self.read_step, actions, self.looks_like_step)
        if lines is not None and not looks_like_json(text, _make_json_plan_format(frozenset(actions))):
            return lines
        plan = super().read(text, actions)
        return lines if isinstance(lines, Unreadable) and isinstance(plan, Unreadable) else plan

    def looks_like_step(self, line: str) -> bool:
        """Whether an unreadable line may be a step, although its first word is not the name of an action."""
        return False

    def read_step(self, line: str) -> WrittenStep | None:
        """Return the step in a line, or None. The line has no comment, and no blanks at its ends."""
        step = _STEP.fullmatch(line)
        words = [] if step is None else step[1].split()
        return WrittenStep(words[0], tuple(words[1:])) if words else None

    def to_operator_name(self, word: str) -> str:
        """Return a name in small letters."""
        return word.lower()

    def make_object_lookup(self, task: Task) -> Callable[[object], int | None]:
        """Return the function that finds objects by their names in the scene; None for unknown names.

        Upper and lower case do not matter.
        """
        index = {name.lower(): i for name, i in task.scene.index.items()}
        return lambda name: index.get(str(name).lower())


@lru_cache(64)
def _make_json_plan_format(actions: frozenset[str]) -> AnswerFormat[StepList]:
    known = {action.casefold() for action in actions}

    def read_steps(value: object) -> StepList | None:
        if not isinstance(value, JsonObject):
            return None
        step = read_step_from_action_and_object_keys(value)
        names = [name for name, _ in value.members]
        if step is None and names and all(name.casefold() in known for name in names):
            step = read_steps_keyed_by_action(value, names)
            return None if step is None else step._replace(repairs=(STEP_FORM,))
        return step

    description = "list of steps with an action and an object"
    return make_plan_format(
        description, read_steps, actions, "plan", lambda text: read_text_of_steps(text, actions)
    )


def _make_objects_schema(object_count: int, words_that_name_objects: Sequence[str] | None) -> Schema:
    if object_count == 0:
        return make_text_schema([""])
    if object_count == 1 or words_that_name_objects is None:
        return make_text_schema(words_that_name_objects)
    one = "(" + "|".join(_SPECIAL.sub(r"\\\g<0>", word) for word in words_that_name_objects) + ")"
    return {**make_text_schema(), "pattern": f"^{', ?'.join([one] * object_count)}$"}


def _write_step(action: Action, scene: Scene) -> str:
    names = ", ".join([scene.objects[i].name for i in action.arguments])
    return json.dumps({"action": action.operator, "object": names})
