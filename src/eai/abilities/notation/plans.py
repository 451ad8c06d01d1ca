"""How plans are written as answers, as a benchmark's prompts ask for them, and what they mean in a task.

A written plan has names before anyone knows whether they mean something; `resolve` finds what they mean:
ground actions. A `Course` is what became of a plan in a world that may have a past, and may fail it.
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.answer_text import ANY_VALUE, MAX_LENGTH, AnswerForm, Pairs, Reading, read_json
from eai.abilities.notation.plan_form import (
    STEP_FORM,
    StepList,
    WrittenPlan,
    WrittenStep,
    keyed_steps,
    labelled_step,
    plan_form,
    read_plan,
)
from eai.abilities.notation.plan_lines import read_lines
from eai.abilities.verdict import UNKNOWN_ACTION, ErrorReport, Unreadable
from eai.base.grouping import group_pairs
from eai.logic.signature import describe_arity
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory
from eai.world.fault import FaultKind
from eai.world.state import Scene

ObjectOf: TypeAlias = Callable[[object], int | None]
"""The index of the object that something written stands for, or None."""


def resolve(
    plan: WrittenPlan,
    domain: Domain,
    notation: PlanNotation,
    object_of: ObjectOf,
    stranger: str = "there is no",
) -> tuple[Action, ...] | ErrorReport:
    """A written plan as ground actions, or its first grammar error: of all names before of any arity.

    Args:
        plan: the plan.
        domain: whose operators are named.
        notation: what operators are called.
        object_of: what objects are called.
        stranger: what there is to say of what stands for no object, before its name.
    """
    arities, operator_of = domain.arities, notation.operator
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
            detail = f"{word}: {stranger} {name}"
            return ErrorReport(FaultKind.HALLUCINATION, number, detail, "unknown_object", (str(name),))
        if misapplied is None and len(objects) != arity:
            detail = f"{describe_arity(operator, arity, 'object')}, not {len(objects)}"
            misapplied = ErrorReport(FaultKind.ARGUMENT_NUMBER, number, detail, "wrong_arity")
        actions.append(Action(operator, objects))
    return misapplied or tuple(actions)


class Course(NamedTuple):
    """The outcome of a plan that was carried out.

    Attributes:
        trajectory: of this plan alone, from the state in which it began.
        before: the actions that were executed earlier in the same world, by name.
        slipped: whether a slip ended it.
        whole: all that has happened in this world, where it did not begin with this plan.
    """

    trajectory: Trajectory
    before: tuple[str, ...] = ()
    slipped: bool = False
    whole: Trajectory | None = None

    @property
    def taken(self) -> list[str]:
        """All actions that were executed in this world, by name."""
        return [*self.before, *[action.operator for action in self.trajectory.executed]]


CarryOut: TypeAlias = Callable[[tuple[Action, ...]], Course]
"""How plans are carried out; one of no steps begins and ends where the world is."""


IMPOSSIBLE, QUESTION = "impossible", "ask"
"""The one member of an answer that there is no plan, and of one that asks."""

_SPECIAL = re.compile(r"[\\^$.|?*+()\[\]{}/]")
_STEP = re.compile(r"(?:[\d.]+\s*:\s*)?\(\s*([^\s()][^()]*)\)\s*(?:\[[\d.]*\])?")


class PlanNotation(ABC):
    """Reads plans from answers and writes them, and knows what operators and objects are called there."""

    @abstractmethod
    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Read the plan in an answer, or say why the answer cannot be read as a whole.

        Args:
            text: the answer.
            actions: the names of actions in answers, by which a step outside the plan is noticed; empty if
                they are not known.
        """

    def operator(self, word: str) -> str:
        """The name of the operator that a word means, if there is one of this name."""
        return word

    @abstractmethod
    def objects(self, task: Task) -> Callable[[object], int | None]:
        """The names of objects in answers to a task.

        Returns a function from what stands for an object in a written step to its index, or None where it
        stands for none.
        """

    @abstractmethod
    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """A plan as the parts of an answer, one a step."""

    @abstractmethod
    def join(self, parts: Iterable[str]) -> str:
        """The parts as one answer."""

    def encoded(self, text: str) -> str:
        """A text with the declared names in the words of answers."""
        return text

    def decoded(self, text: str) -> str:
        """A text in the words of answers with the declared names."""
        return text

    def command(self, operator: str, names: Sequence[str]) -> str:
        """An action on objects of these names as one line of an agent, such as ``OPEN(jar_0)``."""
        return f"{operator}({', '.join(names)})"

    def words(self, task: Task) -> tuple[str, ...]:
        """The words for objects in questions about a task, each once; none if they are not known."""
        return ()

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """The form of an answer, for providers that can enforce one; None if it is not known.

        Args:
            domain: the actions.
            words: what objects may be called; None if any text will do.
        """
        return None


class JsonPlans(PlanNotation):
    """The default notation: a list of steps, each an action with its object, by the names that a task has.

    ``[{"action": "OPEN", "object": "jar_0"}]``: two objects are separated by a comma or stand in a list, an
    empty text is no object.
    Repairs are those of `eai.abilities.answer_text`, and ``step_form`` for a step ``{"OPEN": ["jar_0"]}``.
    """

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Read the plan in an answer. A plan without steps is an empty list."""
        return read_plan(text, _form(frozenset(actions)))

    def objects(self, task: Task) -> Callable[[object], int | None]:
        """Return the lookup of names of the scene; ``jar.0`` means ``jar_0``, as subgoals spell it."""
        index = task.scene.index

        def object_of(word: object) -> int | None:
            if not isinstance(word, str):
                return None
            return index[word] if word in index else index.get("_".join(word.rsplit(".", 1)))

        return object_of

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Each step as ``{"action": "OPEN", "object": "jar_0"}``."""
        return tuple([_written(action, scene) for action in plan])

    def join(self, parts: Iterable[str]) -> str:
        """A list of the steps."""
        return "[" + ", ".join(parts) + "]"

    def words(self, task: Task) -> tuple[str, ...]:
        """The names of the objects."""
        return tuple([task.scene.objects[index].name for index in task.relevant])

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """An object around the list, as a list alone cannot be enforced."""
        names = group_pairs((operator.arity, operator.name) for operator in domain.operators)
        steps = [closed({"action": text(names[n]), "object": _objects(n, words)}) for n in sorted(names)]
        return closed({"plan": listed(either(steps))})


class PddlPlans(JsonPlans):
    """JSON plans, or lines as planners write them, in which names have any case.

    ``(pick ball1 rooma left) ; cost 1``: comments, the time before a step and its duration in brackets are
    passed over, and so are numbers before a step. A line between steps that is no step cannot be read.
    """

    def read(self, text: str, actions: Collection[str] = ()) -> WrittenPlan | Unreadable:
        """Read the plan in the lines of an answer, or in its JSON if no line is a step."""
        plan = None
        if len(text) <= MAX_LENGTH:
            plan = read_lines(text, self.step, actions, self.looks_like_step)
        return super().read(text, actions) if plan is None else plan

    def looks_like_step(self, line: str) -> bool:
        """Whether a line that cannot be read as a step looks like one, whatever its first word is."""
        return False

    def step(self, line: str) -> WrittenStep | None:
        """The step that a line is, without remarks and the space around it; None if it is none."""
        step = _STEP.fullmatch(line)
        words = [] if step is None else step[1].split()
        return WrittenStep(words[0], tuple(words[1:])) if words else None

    def operator(self, word: str) -> str:
        """Names are in small letters."""
        return word.lower()

    def objects(self, task: Task) -> Callable[[object], int | None]:
        """The names of the scene, in any case."""
        index = {name.lower(): i for name, i in task.scene.index.items()}
        return lambda name: index.get(str(name).lower())


def refusal(reason: str, how: str = IMPOSSIBLE) -> str:
    """The answer that a task is impossible for a reason, or (`QUESTION`) a question about it."""
    return json.dumps({how: reason})


def reason_of(text: str, how: str = IMPOSSIBLE) -> str | None:
    """Return why a task is impossible, or the question that an answer asks instead of a plan.

    None if the last JSON value of the answer is not an object with this one member.
    """
    reading = read_json(text, ANY_VALUE)
    value = reading.value if isinstance(reading, Reading) else None
    members = value.members if isinstance(value, Pairs) else ()
    reasons = [reason for name, reason in members if name == how and isinstance(reason, str)]
    return reasons[0] if len(members) == 1 and reasons else None


@lru_cache(64)
def _form(actions: frozenset[str]) -> AnswerForm[StepList]:
    def step_of(value: object) -> StepList | None:
        if not isinstance(value, Pairs):
            return None
        step = labelled_step(value)
        if step is None and value.members and all(name in actions for name, _ in value.members):
            step = keyed_steps(value, actions)
            return None if step is None else step._replace(repairs=(STEP_FORM,))
        return step

    return plan_form("list of steps with an action and an object", step_of, actions, "plan")


def _objects(number: int, words: Sequence[str] | None) -> Schema:
    """So many objects as one text."""
    if number == 0:
        return text([""])
    if number == 1 or words is None:
        return text(words)
    one = "(" + "|".join(_SPECIAL.sub(r"\\\g<0>", word) for word in words) + ")"
    return {**text(), "pattern": f"^{', ?'.join([one] * number)}$"}


def _written(action: Action, scene: Scene) -> str:
    names = ", ".join([scene.objects[i].name for i in action.arguments])
    return json.dumps({"action": action.operator, "object": names})
