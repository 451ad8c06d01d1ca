"""How plans are written as answers, as a benchmark's prompts ask for them, and what they mean in a task.

A written plan has names before anyone knows whether they mean something; `resolve` finds what they mean:
ground actions. A `Course` is what became of a plan in a world that may have a past, and may fail it.
"""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias

from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.json_text import MAX_LENGTH, Pairs, find_json, is_cut_off
from eai.abilities.scorer import UNKNOWN_ACTION
from eai.abilities.task import Task
from eai.abilities.verdict import ErrorReport, Unreadable
from eai.data.grouping import grouped
from eai.logic.signature import takes
from eai.world.domain import Domain
from eai.world.execution import Action, Trajectory
from eai.world.fault import FaultKind
from eai.world.state import Scene


class WrittenStep(NamedTuple):
    """One step of an answer.

    Attributes:
        action: the action as written.
        objects: what stands for each of its objects; the text of it is what messages call the object.
    """

    action: str
    objects: tuple[object, ...]


@dataclass(frozen=True, slots=True)
class WrittenPlan:
    """The steps of an answer in order, and the names of the repairs that were needed to read them."""

    steps: tuple[WrittenStep, ...]
    repairs: tuple[str, ...] = ()


TOO_LONG = Unreadable(f"the answer is longer than {MAX_LENGTH:,} characters")
"""The remark on an answer that no model writes; it is not searched."""


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
            detail = f"{takes(operator, arity, 'object')}, not {len(objects)}"
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
_REMARK = re.compile(r";[^\n]*")
_STEP = re.compile(r"(?:[\d.]+\s*:\s*)?\(\s*([^\s()][^()]*)\)\s*(?:\[[\d.]*\])?")
_COMMENT = re.compile(r"(?<=[\[\]{},\s])#[^\n]*")


class PlanNotation(ABC):
    """Reads plans from answers and writes them, and knows what operators and objects are called there."""

    @abstractmethod
    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan in an answer, or why there is none."""

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
    Fences, prose, single quotes and comments are accepted; every repair is named.
    """

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan in the last JSON value of an answer that is one."""
        found = find_json(text, _steps)
        if found is not None:
            return WrittenPlan(*found)
        without = _COMMENT.sub("", text)
        found = find_json(without, _steps) if without != text else None
        if found is None:
            reason = "no list of steps with an action and an object was found"
            if is_cut_off(without):
                return Unreadable(f"{reason}; a bracket is not closed, as where an answer is cut off")
            flaw = find_json(without, _flaw)
            return Unreadable(reason if flaw is None else f"{reason}: {flaw[0]}")
        plan = WrittenPlan(*found)
        return replace(plan, repairs=(*plan.repairs, "comments"))

    def objects(self, task: Task) -> Callable[[object], int | None]:
        """The names of the scene."""
        return dict[object, int](task.scene.index.items()).get

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
        names = grouped((operator.arity, operator.name) for operator in domain.operators)
        steps = [closed({"action": text(names[n]), "object": _objects(n, words)}) for n in sorted(names)]
        return closed({"plan": listed(either(steps))})


class PddlPlans(JsonPlans):
    """JSON plans, or lines as planners write them, in which names have any case.

    ``(pick ball1 rooma left) ; cost 1``: comments, the time before a step and its duration in brackets are
    passed over. Of several blocks of such lines the last one is the plan.
    """

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan in the last JSON value of an answer that is one, else in its last lines that are steps."""
        found = super().read(text)
        if isinstance(found, WrittenPlan) or len(text) > MAX_LENGTH:
            return found
        return _of_lines(text, self.step) or found

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


def _of_lines(text: str, step_of: Callable[[str], WrittenStep | None]) -> WrittenPlan | None:
    """The plan in the last lines of a text that are steps; None if there are none."""
    steps: list[WrittenStep] = []
    others, is_over = dict[str, None](), False
    for line in map(str.strip, _REMARK.sub("", text).splitlines()):
        step = step_of(line)
        if step is not None:
            if is_over:
                steps, is_over = [], False
            steps.append(step)
        elif line:
            others["code_fence" if line.startswith("```") else "prose"] = None
            is_over = True
    return WrittenPlan(tuple(steps), tuple(others)) if steps else None


def refusal(reason: str, how: str = IMPOSSIBLE) -> str:
    """The answer that a task is impossible for a reason, or (`QUESTION`) a question about it."""
    return json.dumps({how: reason})


def reason_of(text: str, how: str = IMPOSSIBLE) -> str | None:
    """Why the task is impossible, or what an answer asks; None if its last JSON value says no such thing."""
    found = find_json(text, lambda value: value if isinstance(value, Pairs | list) else None)
    members = found[0].members if found is not None and isinstance(found[0], Pairs) else ()
    reasons = [reason for name, reason in members if name == how and isinstance(reason, str)]
    return reasons[0] if len(members) == 1 and reasons else None


def _steps(value: object) -> tuple[WrittenStep, ...] | None:
    """The steps of a JSON value that is a plan of at least one step, or None."""
    if isinstance(value, Pairs) and len(value.members) == 1:
        return _steps(value.members[0][1])
    if not isinstance(value, list):
        return None
    steps = []
    for item in value:
        step = _step(item)
        if step is None:
            return None
        steps.append(step)
    return tuple(steps) or None


def _flaw(value: object) -> str | None:
    """The first item of a list of steps that is none, in words; None of any other value."""
    if isinstance(value, Pairs) and len(value.members) == 1:
        return _flaw(value.members[0][1])
    if not isinstance(value, list) or not any(map(_step, value)):
        return None
    number, item = next((number, item) for number, item in enumerate(value, 1) if _step(item) is None)
    members = dict(item.members) if isinstance(item, Pairs) else {}
    missing = [key for key in ("action", "object") if key not in members]
    return f'step {number} has no "{missing[0]}"' if missing else f"step {number} has another form"


def _step(value: object) -> WrittenStep | None:
    if not isinstance(value, Pairs):
        return None
    members = value.members
    if len(members) == 2 and members[0][0] == "action" and members[1][0] == "object":
        action, objects = members[0][1], members[1][1]  # as prompts have it
    else:
        by_key = dict(members)
        action, objects = by_key.get("action"), by_key.get("object")
    if not isinstance(action, str):
        return None
    if isinstance(objects, str):
        if "," in objects:
            return WrittenStep(action, named(objects.split(",")))
        return WrittenStep(action, (name,) if (name := objects.strip()) else ())
    return WrittenStep(action, named(map(str, objects))) if isinstance(objects, list) else None


def _objects(number: int, words: Sequence[str] | None) -> Schema:
    """So many objects as one text."""
    if number == 0:
        return text([""])
    if number == 1 or words is None:
        return text(words)
    one = "(" + "|".join(_SPECIAL.sub(r"\\\g<0>", word) for word in words) + ")"
    return {**text(), "pattern": f"^{', ?'.join([one] * number)}$"}


def named(words: Iterable[str]) -> tuple[str, ...]:
    """Words as names of objects: without the space around them."""
    return tuple(map(str.strip, words))


def _written(action: Action, scene: Scene) -> str:
    names = ", ".join([scene.objects[i].name for i in action.arguments])
    return json.dumps({"action": action.operator, "object": names})
