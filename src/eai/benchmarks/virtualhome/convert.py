"""Convert the published wheel to the pack (data package) `virtualhome`: one scene, and a line for each task.

The wheel contains 376 MB of scene graphs. The 342 graph files of the tasks are read one after the other,
without unpacking them to disk.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, NamedTuple, TypeVar

from eai.base.errors import DataError
from eai.base.grouping import group_pairs
from eai.base.source import ArchiveFiles
from eai.base.store import ReportProgress
from eai.benchmarks.virtualhome.records import TASKS_MEMBER, Edge, SceneObjectRecord

RESOURCES = "virtualhome_eval/resources/"
GOALS_FILE = f"{RESOURCES}virtualhome/task_state_LTL_formula_accurate.json"
_PROGRAMS = "virtualhome_eval/dataset/programs_processed_precond_nograb_morepreconds/"
_GRAPHS = f"{_PROGRAMS}init_and_final_graphs/"
_SCENE = "TrimmedTestScene1_graph/results_intentions_march-13-18/file"
_ORDERED_RELATIONS = frozenset({"ON", "INSIDE"})
_STEP = re.compile(r"\[(\w+)\]((?: <[^<>]+> \((?:\d+\.)?\d+\))*)")
_STEP_OBJECT = re.compile(r"<([^<>]+)> \((?:\d+\.)?(\d+)\)")

_NO_GOALS: Mapping[str, Any] = {"vh_goal": {"goal": [], "actions": []}, "tl_goal": None}

T = TypeVar("T")


def _get_or_assign_number(value: T, numbers: dict[T, int]) -> int:
    """Return the number of a value.

    Numbers count from 0 in order of first use. Equal values have one number.
    """
    return numbers.setdefault(value, len(numbers))


class _HomeGraph(NamedTuple):
    """A scene graph: objects by ascending id, and edges in file order without duplicates."""

    objects: Sequence[SceneObjectRecord]
    edges: Sequence[Edge]


class _UnconvertedTask(NamedTuple):
    """A task of the paper's Python package, with the graphs of the home before and after its plan."""

    id: str
    annotation: Mapping[str, Any]
    script: str
    initial: _HomeGraph
    final: _HomeGraph


def _read_graph_with_interned_records(
    values: Mapping[str, Any],
    interned_objects: dict[SceneObjectRecord, SceneObjectRecord],
    interned_edges: dict[Edge, Edge],
) -> _HomeGraph:
    """Read a graph. Graphs share equal objects and edges, so that 342 graphs fit into 20 MB of memory.

    If several nodes have one id, the last node counts, as in the loader of the paper's package. Duplicate
    edges are dropped.
    """
    nodes = {node["id"]: node for node in values["nodes"]}
    records = map(_read_object, [nodes[identifier] for identifier in sorted(nodes)])
    edges_read = [(edge["from_id"], edge["relation_type"], edge["to_id"]) for edge in values["edges"]]
    return _HomeGraph(
        tuple([interned_objects.setdefault(record, record) for record in records]),
        tuple(dict.fromkeys([interned_edges.setdefault(edge, edge) for edge in edges_read])),
    )


def _read_object(node: Mapping[str, Any]) -> SceneObjectRecord:
    return SceneObjectRecord(
        node["id"],
        node["class_name"],
        node["category"],
        tuple(sorted(set(node["properties"]))),
        tuple(sorted(set(node["states"]))),
    )


def convert_tasks(wheel: ArchiveFiles, report: ReportProgress) -> dict[str, bytes]:
    """Return the files of the data that `virtualhome` reads: content by file name.

    They are made from the wheel, the paper's published Python package.

    Raises:
        DataError: the wheel lacks a file, or a file has an unexpected form.
    """
    return {TASKS_MEMBER: _convert_annotated_tasks(wheel, _read_goal_annotations_by_task(wheel), report)}


def convert_demonstrations_to_task_lines(wheel: ArchiveFiles, report: ReportProgress) -> bytes:
    """Return all published plans of people (demonstrations) in the scene, as lines of a task file.

    The wheel is the paper's published Python package. Some of the tasks have no annotated goal.

    Raises:
        DataError: the wheel lacks a file, or a file has an unexpected form.
    """
    prefix, annotated = f"{_GRAPHS}{_SCENE}", _read_goal_annotations_by_task(wheel)
    task_ids = [
        name.removeprefix(prefix).removesuffix(".json") for name in wheel.names if name.startswith(prefix)
    ]
    return _convert_annotated_tasks(
        wheel, {task_id: annotated.get(task_id, _NO_GOALS) for task_id in sorted(task_ids)}, report
    )


def _read_goal_annotations_by_task(wheel: ArchiveFiles) -> dict[str, Mapping[str, Any]]:
    """Return a mapping from task id to annotated goals, in the order of the data set."""
    goals = json.loads(wheel.read(GOALS_FILE))["scene_1"]
    return {
        task_id: {"title": title, **goal} for title, tasks in goals.items() for task_id, goal in tasks.items()
    }


def _convert_annotated_tasks(
    wheel: ArchiveFiles, annotations: Mapping[str, Mapping[str, Any]], report: ReportProgress
) -> bytes:
    objects: dict[SceneObjectRecord, SceneObjectRecord] = {}
    edges: dict[Edge, Edge] = {}
    sources = []
    for done, (task_id, annotation) in enumerate(annotations.items()):
        report("converting", "VirtualHome tasks", done, len(annotations))
        graphs = json.loads(wheel.read(f"{_GRAPHS}{_SCENE}{task_id}.json"))
        script = wheel.read(f"{_PROGRAMS}executable_programs/{_SCENE}{task_id}.txt").decode()
        initial, final = (
            _read_graph_with_interned_records(graphs[name], objects, edges)
            for name in ("init_graph", "final_graph")
        )
        sources.append(_UnconvertedTask(task_id, annotation, script, initial, final))
    report("converting", "VirtualHome tasks", len(annotations), len(annotations))
    return _encode_tasks(sources, list(objects))


def _encode_tasks(sources: Sequence[_UnconvertedTask], objects: Sequence[SceneObjectRecord]) -> bytes:
    encoder = _TaskEncoder({record: number for number, record in enumerate(objects)})
    base = encoder.compute_common_graph(sources)
    base_edges = encoder.flatten_edges(base.edges)
    lines = [encoder.encode_task(source, base) for source in sources]
    labels: dict[tuple[str, ...], int] = {}
    header = {
        "tasks": [source.id for source in sources],
        "relations": list(encoder.relations),
        "base_objects": [encoder.objects[record] for record in base.objects],
        "base_edges": base_edges,
        "objects": [
            [
                o.id,
                o.class_name,
                o.category,
                _get_or_assign_number(o.properties, labels),
                _get_or_assign_number(o.states, labels),
            ]
            for o in objects
        ],
        "labels": list(labels),
    }
    return b"".join(json.dumps(line, separators=(",", ":")).encode() + b"\n" for line in [header, *lines])


@dataclass(frozen=True, slots=True)
class _TaskEncoder:
    """Encodes the graphs of tasks as differences from another graph. Objects and relations become numbers."""

    objects: Mapping[SceneObjectRecord, int]
    relations: dict[str, int] = field(default_factory=dict)

    def flatten_edges(self, edges: Iterable[Edge]) -> list[int]:
        """Return edges as one list of numbers: source, relation and target of each edge in turn."""
        numbered = (
            (source, _get_or_assign_number(name, self.relations), target) for source, name, target in edges
        )
        return list(chain.from_iterable(numbered))

    def compute_common_graph(self, tasks: Sequence[_UnconvertedTask]) -> _HomeGraph:
        """Return the graph of the object ids and edges that all initial graphs have.

        Each object has the description that is most frequent in these graphs.
        """
        counts = Counter(record for source in tasks for record in source.initial.objects)
        variants = group_pairs((record.id, record) for record in counts)
        shared = [
            max(records, key=lambda record: (counts[record], -self.objects[record]))
            for _, records in sorted(variants.items())
            if sum(counts[record] for record in records) == len(tasks)
        ]
        first, *others = (source.initial.edges for source in tasks)
        common = set(first).intersection(*others)
        return _HomeGraph(shared, _sort_edges([edge for edge in first if edge in common]))

    def encode_difference(
        self, before: _HomeGraph, after: _HomeGraph, *, keep_order: bool
    ) -> dict[str, list[int]]:
        """Return the changes that turn one graph into another.

        With `keep_order`, the edges of a source object are removed and appended again if their order changes.
        """
        old, new = ({record.id: record for record in graph.objects} for graph in (before, after))
        changed = [record for key, record in new.items() if key in old and old[key] != record]
        appended = [record for key, record in new.items() if key not in old]
        removed = set(before.edges).difference(after.edges)
        added = set(after.edges).difference(before.edges)
        if keep_order:
            moved = _find_reordered_edges(before, after, removed)
            removed |= moved.intersection(before.edges)
            added |= moved
        return {
            "removed_ids": [identifier for identifier in old if identifier not in new],
            "changed_objects": [self.objects[record] for record in changed],
            "added_objects": [self.objects[record] for record in appended],
            "removed_edges": self.flatten_edges(
                _sort_edges(edge for edge in before.edges if edge in removed)
            ),
            "added_edges": self.flatten_edges(_sort_edges(edge for edge in after.edges if edge in added)),
        }

    def encode_task(self, source: _UnconvertedTask, base: _HomeGraph) -> dict[str, object]:
        title, description, script = _read_title_description_and_steps(source)
        nodes, edges = _find_ids_of_changed_objects_and_edges(source.initial, source.final)
        goal = source.annotation["vh_goal"]
        states = [entry for entry in goal["goal"] if "state" in entry]
        relations = [entry for entry in goal["goal"] if "relation_type" in entry]
        return {
            "id": source.id,
            "title": title,
            "description": description,
            "script": script,
            "node_goals": [[entry["id"], entry["class_name"], entry["state"]] for entry in states],
            "edge_goals": [[entry["from_id"], entry["relation_type"], entry["to_id"]] for entry in relations],
            "action_goals": [entry.split("|") for entry in goal["actions"]],
            "tl_goal": source.annotation["tl_goal"],
            "initial": self.encode_difference(base, source.initial, keep_order=True),
            "final": self.encode_difference(source.initial, source.final, keep_order=False),
            "relevant_from_nodes": nodes,
            "relevant_from_edges": edges,
        }


def _sort_edges(edges: Iterable[Edge]) -> list[Edge]:
    """Sort edges by source and relation, and then by the id of the target.

    Edges of the relations `ON` and `INSIDE` are not sorted by target.
    """

    def make_sort_key(edge: Edge) -> tuple[int, str, int]:
        source, relation, target = edge
        return source, relation, 0 if relation in _ORDERED_RELATIONS else target

    return sorted(edges, key=make_sort_key)


def _find_reordered_edges(before: _HomeGraph, after: _HomeGraph, removed_edges: set[Edge]) -> set[Edge]:
    """Return the `ON` or `INSIDE` edges of each object for which the order of these edges changed.

    The order is unchanged if the list of edges begins with the old edges that were not removed. If the order
    changed, all edges of the list must be written again.
    """
    stayed = _group_ordered_edges_by_source_and_relation(
        edge for edge in before.edges if edge not in removed_edges
    )
    return {
        edge
        for key, edges in _group_ordered_edges_by_source_and_relation(after.edges).items()
        if (first := stayed.get(key, [])) != edges[: len(first)]
        for edge in edges
    }


def _group_ordered_edges_by_source_and_relation(edges: Iterable[Edge]) -> dict[tuple[int, str], list[Edge]]:
    """Return a mapping from source and relation to edges, for the relations `ON` and `INSIDE`."""
    return group_pairs((edge[:2], edge) for edge in edges if edge[1] in _ORDERED_RELATIONS)


def _find_ids_of_changed_objects_and_edges(
    initial: _HomeGraph, final: _HomeGraph
) -> tuple[list[int], list[int]]:
    """Return the ids of changed objects, and the ids at ends of changed edges, in order of occurrence."""
    nodes = [record.id for record in _list_items_in_only_one(initial.objects, final.objects)]
    ends = [end for edge in _list_items_in_only_one(initial.edges, final.edges) for end in edge[::2]]
    return list(dict.fromkeys(nodes)), list(dict.fromkeys(ends))


def _list_items_in_only_one(before: Sequence[T], after: Sequence[T]) -> list[T]:
    """Return the items that only one sequence has. Items of `before` come first."""
    old, new = set(before), set(after)
    return [item for item in before if item not in new] + [item for item in after if item not in old]


def _read_title_description_and_steps(task: _UnconvertedTask) -> tuple[str, str, list[object]]:
    title, description, *lines = task.script.splitlines()
    if task.annotation.get("title", title) != title:
        raise DataError(
            f"script of {task.id}: title {title!r}, but the annotation has {task.annotation['title']!r}; "
            "download the archive again"
        )
    steps: list[object] = []
    for line in filter(None, map(str.strip, lines)):
        match = _STEP.fullmatch(line)
        if match is None:
            raise DataError(f"script of {task.id}: {line!r} is not a step; expected `[ACTION] <object> (id)`")
        objects = [[name, int(number)] for name, number in _STEP_OBJECT.findall(match[2])]
        steps.append([match[1], objects])
    return title, description, steps
