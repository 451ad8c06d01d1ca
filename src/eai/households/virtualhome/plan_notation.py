"""Plans as VirtualHome's prompts require them: actions with lists of objects, by class or by class and id.

``{"WALK": ["sofa"], "SIT": ["sofa"]}`` or ``{"WALK": ["sofa", "352"], "SIT": ["sofa", "352"]}``, in order and
with repeated keys.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import starmap, zip_longest
from typing import NamedTuple

from eai.abilities.answer_schema import Schema, closed, either, listed, text
from eai.abilities.json_text import MAX_LENGTH, Pairs, find_json
from eai.abilities.notation.plans import TOO_LONG, PlanNotation, WrittenPlan, WrittenStep
from eai.abilities.task import Task
from eai.abilities.verdict import Unreadable
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.state import Scene

_STEPS = "action commands"
"""The key of the steps where the form of an answer is enforced; of one word the reference makes a step."""

_STEP = re.compile(r"""["'](\w+)["']\s*:\s*(\[[^\[\]{}]*\])""")


class Identified(NamedTuple):
    """An object by class and id, as written; the id is None where a list ends before it."""

    name: object
    id: object

    def __str__(self) -> str:
        return f"{self.name} without an id" if self.id is None else f"{self.name}_{self.id}"


class VirtualHomePlans(PlanNotation):
    """The notation of VirtualHome.

    Lists of such JSON objects, an object around them, fences, prose, single quotes and operators in lower
    case are accepted. An answer is read with ids if a number stands where one would. A class alone means the
    last object of it that the task is about; with its id, any object of the scene may be named.
    """

    def read(self, text: str) -> WrittenPlan | Unreadable:
        """The plan in the last JSON value of an answer that is one, else all pairs in the text."""
        plan = read_steps(text)
        return identified(plan) if isinstance(plan, WrittenPlan) and has_ids(plan) else plan

    def operator(self, word: str) -> str:
        """Operators have names in capitals."""
        return word.upper()

    def objects(self, task: Task) -> Callable[[object], int | None]:
        """The classes of the task's objects, and all objects of the scene by class and id."""
        return index_of({task.scene.objects[i].category: i for i in task.relevant}, task.scene.index)

    def write(self, plan: Iterable[Action], scene: Scene) -> tuple[str, ...]:
        """Each step as ``"GRAB": ["soap", "1002"]``; the reference needs the blank in an empty list."""
        return tuple([_written(action, scene) for action in plan])

    def join(self, parts: Iterable[str]) -> str:
        """A JSON object of the steps."""
        return "{" + ", ".join(parts) + "}"

    def words(self, task: Task) -> tuple[str, ...]:
        """Their classes, and their ids."""
        named = [task.scene.objects[index].name.rsplit(".", 1) for index in task.relevant]
        return tuple(dict.fromkeys([word for words in zip(*named, strict=True) for word in words]))

    def schema(self, domain: Domain, words: Sequence[str] | None) -> Schema:
        """A list of objects of one step each, as an action may occur more than once, and no key may."""
        steps = [
            closed({each.name: listed(text(words if each.arity else None))}) for each in domain.operators
        ]
        return closed({_STEPS: listed(either(steps))})


def index_of(
    by_class: Mapping[str, int], by_name: Mapping[str, int], joint: str = "."
) -> Callable[[object], int | None]:
    """Return the lookup of what is written as a class, or as a class and an id, joined in names."""

    def found(word: object) -> int | None:
        if isinstance(word, str):
            return by_class.get(word)
        return by_name.get(f"{word.name}{joint}{word.id}") if isinstance(word, Identified) else None

    return found


def has_ids(plan: WrittenPlan) -> bool:
    """Whether a plan names objects with their ids: a number stands where an id would."""
    return any(_is_id(word) for step in plan.steps for word in step.objects[1::2])


def identified(plan: WrittenPlan) -> WrittenPlan:
    """The plan with a class and an id as one object."""
    steps = [WrittenStep(step.action, _in_pairs(step.objects)) for step in plan.steps]
    return WrittenPlan(tuple(steps), plan.repairs)


def _in_pairs(words: tuple[object, ...]) -> tuple[Identified, ...]:
    return tuple(starmap(Identified, zip_longest(words[::2], words[1::2])))


def _is_id(word: object) -> bool:
    return isinstance(word, int) or (isinstance(word, str) and word.isdigit())


def read_steps(text: str) -> WrittenPlan | Unreadable:
    """The steps of an answer, as written."""
    if len(text) > MAX_LENGTH:
        return TOO_LONG
    found = find_json(text, _steps)
    return _scan(text) if found is None else WrittenPlan(*found)


def _steps(value: object) -> tuple[WrittenStep, ...] | None:
    """The steps of a JSON value that is a plan of at least one step, or None."""
    if isinstance(value, list):
        parts = [_steps(item) for item in value]
        if not parts or any(part is None for part in parts):
            return None
        return tuple(step for part in parts if part is not None for step in part)
    if not isinstance(value, Pairs) or not value.members:
        return None
    wrapped = _steps(value.members[0][1]) if len(value.members) == 1 else None
    if wrapped is not None:
        return wrapped
    steps = []
    for action, arguments in value.members:
        if not isinstance(arguments, list):
            return None
        steps.append(WrittenStep(action, tuple(arguments)))
    return tuple(steps)


def _scan(text: str) -> WrittenPlan | Unreadable:
    """All ``"ACTION": [...]`` pairs of a text that is not JSON, say because it is cut off."""
    steps: list[WrittenStep] = []
    for match in _STEP.finditer(text):
        action, written = match.groups()
        try:
            arguments = json.loads(written.replace("'", '"'))
        except ValueError:
            return Unreadable(f"the list of step {len(steps) + 1} ({action}) is not JSON")
        steps.append(WrittenStep(action, tuple(arguments)))
    if not steps:
        return Unreadable("no step was found")
    return WrittenPlan(tuple(steps), ("broken_json",))


def _written(action: Action, scene: Scene) -> str:
    words = [part for i in action.arguments for part in scene.objects[i].name.rsplit(".", 1)]
    return f"{json.dumps(action.operator)}: {json.dumps(words) if words else '[ ]'}"
