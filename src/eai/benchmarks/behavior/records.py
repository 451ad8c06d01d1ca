"""The published data of each BEHAVIOR task (record): a line of text in the data store, decoded on first use.

Records have only facts of published files. The module `evidence` has facts that no published file states. The
module `tasks` makes scenes and goals from the data of both modules.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from eai.base.store import PackFile
from eai.benchmarks.behavior.predicates import STATES
from eai.pddl.bddl import parse_problem
from eai.pddl.model import PddlProblem
from eai.tasks.source import TaskSet

PACK = "behavior"
"""Name of the data package (pack) with the published data of BEHAVIOR's tasks."""

TASKS_MEMBER = "tasks.jsonl"
"""Name of the file with one task a line, in data set order. The file is in the data package `PACK`."""

OPTIONS_MEMBER = "goal_options.jsonl"
"""Name of the file with all options (sets of conditions that reach a goal) for goal interpretation.

Each line holds the options of one task, in the order of the data set. The file is in the data package `PACK`.
"""

FLOOR = "room_floor"
"""Category of the 3D models of floors, as the data set spells it."""

STATE_OF_ABILITY: Mapping[str, str] = {
    ability.name: state.name.removeprefix("is_") for ability, state in STATES
}
"""Ability in the taxonomy -> state that the ability makes possible."""

GoalCondition: TypeAlias = tuple[str | tuple[str, ...], ...]
"""A literal of a goal: ``(predicate, instance, ...)``, or ``("not", (predicate, instance, ...))``."""

GroundOption: TypeAlias = tuple[GoalCondition, ...]
"""One option to reach a goal: conditions that must all hold. A goal can have several options."""


@dataclass(frozen=True, slots=True)
class BehaviorObject:
    """An object of a BEHAVIOR task, with its names in actions, in BDDL and in the simulator.

    Attributes:
        name: name in actions, such as ``rag_51``.
        instance: name in BDDL, such as ``rag.n.01_1``.
        category: synset in the problem's declaration.
        model: category of the object's 3D model in the simulator, such as ``rag``; `FLOOR` for floors.
        synset: synset of the 3D model's category in the taxonomy of objects.
        abilities: abilities that the taxonomy gives to the synset, sorted.
    """

    name: str
    instance: str
    category: str
    model: str
    synset: str
    abilities: tuple[str, ...]

    @property
    def is_floor(self) -> bool:
        """Whether the object is a floor."""
        return self.model == FLOOR

    @property
    def possible_states(self) -> tuple[str, ...]:
        """Names of the state predicates that can hold for this object."""
        return tuple(state for ability, state in STATE_OF_ABILITY.items() if ability in self.abilities)

    @property
    def names_of_sliced_halves(self) -> tuple[str, ...]:
        """Names of the two halves of a sliceable object; empty for other objects."""
        return tuple(f"{self.name}_part_{i}" for i in range(2)) if "sliceable" in self.abilities else ()


@dataclass(frozen=True, slots=True)
class BehaviorRecord:
    """A task as the published files state it.

    Attributes:
        id: the data set's id: activity, definition, scene, instance and date of a recorded demonstration.
        activity: the activity, such as ``bottling_fruit``.
        definition: number of the problem file, among the problem files of the activity.
        scene: the simulator's scene.
        instruction: the activity in one English sentence.
        objects: objects in the order of the problem file, without the agent.
        problem: the problem file, which uses BDDL names of objects (`BehaviorObject.instance`).
        plan: a human's plan from the data set, as actions with objects. The data set misspells one action.
        goal_options: for each goal of goal interpretation, all options (sets of conditions that reach the
            goal), in the published order. For three tasks, the options were made from an earlier version of
            the problem file than `problem`.
    """

    id: str
    activity: str
    definition: int
    scene: str
    instruction: str
    objects: tuple[BehaviorObject, ...]
    problem: PddlProblem
    plan: tuple[tuple[str, tuple[str, ...]], ...]
    goal_options: tuple[tuple[GroundOption, ...], ...]


def read_records(pack: PackFile) -> TaskSet[BehaviorRecord]:
    """Return the published data of each task (record) by task id, in data set order, decoded on first use."""
    lines = _map_task_ids_to_json(pack.read_member(TASKS_MEMBER))
    options = _map_task_ids_to_json(pack.read_member(OPTIONS_MEMBER))

    def read_record(task_id: str) -> BehaviorRecord:
        return _read_record(task_id, json.loads(lines[task_id]), json.loads(options[task_id]))

    return TaskSet(lines, read_record, pack.sha256)


def _map_task_ids_to_json(content: bytes) -> dict[str, bytes]:
    """Return a mapping from task id to JSON text. A line of the content is an id, a tab and JSON."""
    pairs = (line.split(b"\t", 1) for line in content.splitlines())
    return {task_id.decode(): text for task_id, text in pairs}


def _read_record(task_id: str, values: Mapping[str, Any], goals: Sequence[Sequence[Any]]) -> BehaviorRecord:
    return BehaviorRecord(
        id=task_id,
        activity=values["activity"],
        definition=values["definition"],
        scene=values["scene"],
        instruction=values["instruction"],
        objects=tuple(
            [
                BehaviorObject(name, instance, category, model, synset, tuple(abilities))
                for name, instance, category, model, synset, abilities in values["objects"]
            ]
        ),
        problem=parse_problem(values["problem"]),
        plan=tuple([(action, tuple(objects)) for action, objects in values["plan"]]),
        goal_options=tuple(
            [tuple([tuple(map(_read_condition, option)) for option in options]) for options in goals]
        ),
    )


def _read_condition(values: Sequence[Any]) -> GoalCondition:
    return ("not", tuple(values[1])) if values[0] == "not" else tuple(values)
