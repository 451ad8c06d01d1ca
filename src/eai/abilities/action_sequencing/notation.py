"""How plans are written as answers: what a benchmark's prompts ask for."""

from __future__ import annotations

import json
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from mypy_extensions import mypyc_attr

from eai.abilities.action_sequencing.plan import WrittenPlan, WrittenStep
from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.json_text import Pairs, find_json, is_cut_off
from eai.abilities.task import Task
from eai.abilities.unreadable import Unreadable
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.state import Scene

_SPECIAL = re.compile(r"[\\^$.|?*+()\[\]{}/]")
_COMMENT = re.compile(r"(?<=[\[\]{},\s])#[^\n]*")


@mypyc_attr(allow_interpreted_subclasses=True)
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
        """What objects are called in answers to a task.

        Returns a function from what stands for an object in a written step to its index, or None where it
        stands for none.
        """

    @abstractmethod
    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """A plan as the parts of an answer, one a step."""

    @abstractmethod
    def join(self, parts: Iterable[str]) -> str:
        """The parts as one answer."""

    def words(self, task: Task) -> tuple[str, ...]:
        """What questions about a task call its objects, each word once; nothing if that is not known."""
        return ()

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema | None:
        """The form of an answer, for providers that can enforce one; None if it is not known.

        Args:
            domain: the actions.
            words: what objects may be called; None if any text will do.
        """
        return None


@mypyc_attr(allow_interpreted_subclasses=True)
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
            open_end = "; a bracket is not closed, as where an answer is cut off"
            return Unreadable(reason + open_end * is_cut_off(without))
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

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """An object around the list, as a list alone cannot be enforced."""
        names: dict[int, list[str]] = {}
        for operator in domain.operators:
            names.setdefault(operator.arity, []).append(operator.name)
        steps = [closed({"action": text(names[n]), "object": _objects(n, words)}) for n in sorted(names)]
        return closed({"plan": listed(either(steps))})


def _steps(value: object) -> tuple[WrittenStep, ...] | None:
    """The steps of a JSON value that is a plan of at least one step, or None."""
    if isinstance(value, Pairs) and len(value.members) == 1:
        return _steps(value.members[0][1])
    if not isinstance(value, list):
        return None
    steps = [_step(item) for item in value]
    if not steps or any(step is None for step in steps):
        return None
    return tuple([step for step in steps if step is not None])


def _step(value: object) -> WrittenStep | None:
    members = dict(value.members) if isinstance(value, Pairs) else {}
    action, objects = members.get("action"), members.get("object")
    if not isinstance(action, str):
        return None
    if isinstance(objects, str):
        return WrittenStep(action, named(objects.split(",")) if objects.strip() else ())
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
