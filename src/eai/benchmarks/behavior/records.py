"""The BEHAVIOR tasks as plain records, read from the store: one text line a task, decoded on first use.

Records hold what published files say and nothing else. What no file says is in `evidence`; scenes
and goals are made from both in `tasks`.
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
"""Name of the pack with the records of BEHAVIOR."""

TASKS_MEMBER = "tasks.jsonl"
"""One line a task, in data set order."""

OPTIONS_MEMBER = "goal_options.jsonl"
"""One line a task, in data set order: what goal interpretation compares answers with."""

FLOOR = "room_floor"
"""The model category of the floor of a room."""

STATE_OF_ABILITY: Mapping[str, str] = {
    ability.name: state.name.removeprefix("is_") for ability, state in STATES
}
"""Which ability of the taxonomy lets an object be in which state."""

GoalCondition: TypeAlias = tuple[str | tuple[str, ...], ...]
"""``(predicate, instance, ...)``, or ``("not", (predicate, instance, ...))``."""

GroundOption: TypeAlias = tuple[GoalCondition, ...]
"""One way to meet a goal: all of these conditions."""


@dataclass(frozen=True, slots=True)
class BehaviorObject:
    """An object of a task.

    Attributes:
        name: as actions name it, such as ``rag_51``.
        instance: as BDDL names it, such as ``rag.n.01_1``.
        category: the synset that the problem declares it with.
        model: its category among the simulator's models, such as ``rag``; `FLOOR` for floors.
        synset: the synset that the taxonomy gives that category; its abilities are the object's.
        abilities: sorted.
    """

    name: str
    instance: str
    category: str
    model: str
    synset: str
    abilities: tuple[str, ...]

    @property
    def is_floor(self) -> bool:
        """Whether it is the floor of a room."""
        return self.model == FLOOR

    @property
    def states(self) -> tuple[str, ...]:
        """The predicates of the states that it can be in."""
        return tuple(state for ability, state in STATE_OF_ABILITY.items() if ability in self.abilities)

    @property
    def half_names(self) -> tuple[str, ...]:
        """The names of what it falls into when it is sliced."""
        return tuple(f"{self.name}_part_{i}" for i in range(2)) if "sliceable" in self.abilities else ()


@dataclass(frozen=True, slots=True)
class BehaviorRecord:
    """One task as the published files have it.

    Attributes:
        id: the data set's id: activity, definition, scene, instance and date of a recorded demonstration.
        activity: the activity, such as ``bottling_fruit``.
        definition: number of the activity's problem file.
        scene: the simulator's scene.
        instruction: the activity in one English sentence.
        objects: in the order of the problem file, without the agent.
        problem: the problem file; it names objects by instance.
        plan: a human's plan as the data set has it (one action is misspelt): actions with their objects.
        goal_options: goal interpretation's goals, each as all its ground options in the published order. They
            are those of an earlier wording of three problems than `problem` (spec: (a)).
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
    """The records of a pack, in data set order; a record is decoded once, on first use."""
    lines, options = _split_by_id(pack.read(TASKS_MEMBER)), _split_by_id(pack.read(OPTIONS_MEMBER))

    def read(task_id: str) -> BehaviorRecord:
        return _read_record(task_id, json.loads(lines[task_id]), json.loads(options[task_id]))

    return TaskSet(lines, read, pack.sha256)


def _split_by_id(content: bytes) -> dict[str, bytes]:
    """The lines of a member: each is an id, a tab and JSON."""
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
