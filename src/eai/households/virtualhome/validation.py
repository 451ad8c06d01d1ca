"""Whether the packs of VirtualHome are the published data: counts, and references between their files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

from eai.data.store import PackFile, Store
from eai.households.packs import PROMPTS, RESOURCES, VIRTUALHOME
from eai.households.published_files import PROBLEMS_MEMBER
from eai.households.virtualhome.benchmark import count_annotated
from eai.households.virtualhome.records import (
    CHARACTER_ID,
    BaseScene,
    Edge,
    GraphDelta,
    ObjectRecord,
    TaskRecord,
    VirtualHome,
)
from eai.tasks.source import Finding

PUBLISHED_COUNTS: Mapping[str, int | float] = MappingProxyType(
    {
        "task names": 26,
        "tasks": 342,
        "instructions": 338,
        "action sequencing tasks": 305,
        "transition modeling tasks": 296,
        "goals": 801,
        "state goals": 340,
        "relation goals": 299,
        "action goals": 162,
        "action steps": 2960,
        "transition models": 33,
    }
)
"""Figures of the published data set, by their labels."""


def check_tasks(store: Store, counts: Mapping[str, int | float] | None = None) -> Iterator[Finding]:
    """Findings of counts and references, given that all packs can be read.

    Args:
        store: the folder of packs.
        counts: label of a statistic -> the figure it should show; that of the published data set if None.
    """
    counts = PUBLISHED_COUNTS if counts is None else counts
    tasks = VirtualHome.of(store.open(VIRTUALHOME))
    resources, prompts = store.open(RESOURCES), store.open(PROMPTS)
    transition_tasks = resources.read_json("success_task.json")
    operators = resources.read_json("gold_action.json")
    for row in count_annotated(tasks, transition_tasks, len(operators)):
        if counts.get(row.label, row.value) != row.value:
            yield Finding(VIRTUALHOME, f"{row.label}: {row.value}, expected {counts[row.label]}")
    for task in tasks.values():
        yield from (
            Finding(VIRTUALHOME, f"task {task.id}: {text}") for text in _task_problems(tasks.base, task)
        )
    named = {**_task_ids(resources, transition_tasks), **_prompt_ids(prompts)}
    for place, identifiers in named.items():
        unknown = sorted(set(identifiers) - set(tasks))
        if unknown:
            yield Finding(place, f"names {len(unknown)} unknown tasks, the first {unknown[0]}")


def _task_ids(resources: PackFile, transition_tasks: Sequence[str]) -> dict[str, Sequence[str]]:
    return {
        f"{RESOURCES}/success_task.json": transition_tasks,
        f"{RESOURCES}/{PROBLEMS_MEMBER}": tuple(resources.read_json(PROBLEMS_MEMBER)),
    }


def _prompt_ids(prompts: PackFile) -> dict[str, Sequence[str]]:
    """Task ids of VirtualHome's prompt files, without the prefix that names the scene."""
    abilities = ("action_sequencing", "subgoal_decomposition", "transition_modeling")
    members = [f"virtualhome/{ability}.json" for ability in abilities]
    return {
        f"{PROMPTS}/{member}": [
            str(prompt["identifier"]).removeprefix("scene_1_") for prompt in prompts.read_json(member)
        ]
        for member in members
    }


def _task_problems(base: BaseScene, task: TaskRecord) -> Iterator[str]:
    """What a task's graphs, goals and script refer to must exist."""
    objects, edges = {each.id: each for each in base.objects}, dict.fromkeys(base.edges)
    for name, delta in (("initial", task.initial), ("final", task.final)):
        yield from (f"{name} graph: {text}" for text in _apply(delta, objects, edges))
    wanted = {goal.id for goal in task.node_goals} | {
        each.id for step in task.script for each in step.objects
    }
    wanted |= {end for goal in task.edge_goals for end in (goal.from_id, goal.to_id)}
    wanted |= {*task.relevant_from_nodes, *task.relevant_from_edges, CHARACTER_ID}
    missing = sorted(wanted - objects.keys())
    if missing:
        yield f"no object {missing[0]} in its graph"


def _apply(delta: GraphDelta, objects: dict[int, ObjectRecord], edges: dict[Edge, None]) -> Iterator[str]:
    """Apply a difference in place; tell what does not fit."""
    for identifier in delta.removed_ids:
        if objects.pop(identifier, None) is None:
            yield f"removes the unknown object {identifier}"
    for known, records in ((True, delta.changed_objects), (False, delta.added_objects)):
        for record in records:
            if (record.id in objects) is not known:
                yield f"object {record.id} is {'unknown' if known else 'there already'}"
            objects[record.id] = record
    for edge in delta.removed_edges:
        if edge not in edges:
            yield f"removes an edge that is not there: {edge}"
        edges.pop(edge, None)
    for edge in delta.added_edges:
        if edge in edges or not {edge.source, edge.target} <= objects.keys():
            yield f"adds an edge twice or between unknown objects: {edge}"
        edges[edge] = None
