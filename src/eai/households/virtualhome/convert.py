"""From the published wheel to the pack `virtualhome`: one shared scene, one compact line a task.

The wheel holds 376 MB of graphs; the 342 that tasks refer to are read one after another, in memory.
"""

from __future__ import annotations

import json
import re
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

from eai.data.source import Bundle
from eai.data.store import Report
from eai.errors import DataError
from eai.households.virtualhome.records import TASKS_MEMBER, Edge, ObjectRecord

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


def _number(value: T, numbers: dict[T, int]) -> int:
    """The number of a value; equal ones have the same, from 0 in the order met."""
    return numbers.setdefault(value, len(numbers))


class _Graph(NamedTuple):
    """Numbers of the objects (by ascending id) and of the edges (in file order, without duplicates)."""

    objects: array[int]
    edges: array[int]


class _Source(NamedTuple):
    """One task as read."""

    id: str
    annotation: Mapping[str, Any]
    script: str
    initial: _Graph
    final: _Graph


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads graphs, sharing equal objects and edges among all of them: 342 graphs then fit into 20 MB."""

    objects: dict[ObjectRecord, int] = field(default_factory=dict)
    edges: dict[Edge, int] = field(default_factory=dict)

    def graph(self, values: Mapping[str, Any]) -> _Graph:
        """The last node per id counts, as in the reference's loader; duplicate edges are dropped."""
        nodes = {node["id"]: node for node in values["nodes"]}
        objects = [_number(_object(nodes[identifier]), self.objects) for identifier in sorted(nodes)]
        edges = [(edge["from_id"], edge["relation_type"], edge["to_id"]) for edge in values["edges"]]
        numbers = dict.fromkeys([_number(edge, self.edges) for edge in edges])
        return _Graph(array("L", objects), array("L", numbers))


def _object(node: Mapping[str, Any]) -> ObjectRecord:
    return ObjectRecord(
        node["id"],
        node["class_name"],
        node["category"],
        tuple(sorted(set(node["properties"]))),
        tuple(sorted(set(node["states"]))),
    )


def convert_tasks(wheel: Bundle, report: Report) -> dict[str, bytes]:
    """The members of the pack `virtualhome`.

    Raises:
        DataError: a file of the wheel is absent or not as expected.
    """
    return {TASKS_MEMBER: _converted(wheel, _annotations(wheel), report)}


def convert_demonstrations(wheel: Bundle, report: Report) -> bytes:
    """All demonstrations of the scene in the form of the tasks, those without an annotated goal among them.

    Raises:
        DataError: a file of the wheel is absent or not as expected.
    """
    place, annotated = f"{_GRAPHS}{_SCENE}", _annotations(wheel)
    found = [name.removeprefix(place).removesuffix(".json") for name in wheel.names if name.startswith(place)]
    return _converted(
        wheel, {task_id: annotated.get(task_id, _NO_GOALS) for task_id in sorted(found)}, report
    )


def _annotations(wheel: Bundle) -> dict[str, Mapping[str, Any]]:
    """Task id -> its annotated goals, in the order of the data set."""
    goals = json.loads(wheel.read(GOALS_FILE))["scene_1"]
    return {
        task_id: {"title": title, **goal} for title, tasks in goals.items() for task_id, goal in tasks.items()
    }


def _converted(wheel: Bundle, annotations: Mapping[str, Mapping[str, Any]], report: Report) -> bytes:
    reader, sources = _Reader(), []
    for done, (task_id, annotation) in enumerate(annotations.items()):
        report("converting", "VirtualHome tasks", done, len(annotations))
        sources.append(_source(wheel, reader, task_id, annotation))
    report("converting", "VirtualHome tasks", len(annotations), len(annotations))
    return _encode(sources, reader)


def _source(wheel: Bundle, reader: _Reader, task_id: str, annotation: Mapping[str, Any]) -> _Source:
    graphs = json.loads(wheel.read(f"{_GRAPHS}{_SCENE}{task_id}.json"))
    script = wheel.read(f"{_PROGRAMS}executable_programs/{_SCENE}{task_id}.txt").decode()
    initial, final = reader.graph(graphs["init_graph"]), reader.graph(graphs["final_graph"])
    return _Source(task_id, annotation, script, initial, final)


def _encode(sources: Sequence[_Source], reader: _Reader) -> bytes:
    encoder = _Encoder(list(reader.objects), list(reader.edges))
    base = encoder.base(sources)
    base_edges = encoder.flat(base.edges)
    lines = [encoder.task(source, base) for source in sources]
    labels: dict[tuple[str, ...], int] = {}
    header = {
        "tasks": [source.id for source in sources],
        "relations": list(encoder.relations),
        "base_objects": list(base.objects),
        "base_edges": base_edges,
        "objects": [
            [o.id, o.class_name, o.category, _number(o.properties, labels), _number(o.states, labels)]
            for o in encoder.objects
        ],
        "labels": list(labels),
    }
    return b"".join(json.dumps(line, separators=(",", ":")).encode() + b"\n" for line in [header, *lines])


@dataclass(slots=True)
class _Encoder:
    """Turns graphs of numbers into the differences that the store holds."""

    objects: Sequence[ObjectRecord]
    edges: Sequence[Edge]
    relations: dict[str, int] = field(default_factory=dict)

    def flat(self, numbers: Iterable[int]) -> list[int]:
        """Edges as one list: source, number of the relation, target, source, ..."""
        values: list[int] = []
        for number in numbers:
            source, relation, target = self.edges[number]
            values += (source, _number(relation, self.relations), target)
        return values

    def base(self, sources: Sequence[_Source]) -> _Graph:
        """Every id and every edge that occur in all initial graphs; of an id, the most frequent record."""
        counts = Counter(number for source in sources for number in source.initial.objects)
        variants: dict[int, list[int]] = {}
        for number in counts:
            variants.setdefault(self.objects[number].id, []).append(number)
        shared = [
            max(numbers, key=lambda number: (counts[number], -number))
            for _, numbers in sorted(variants.items())
            if sum(counts[number] for number in numbers) == len(sources)
        ]
        common = set(sources[0].initial.edges).intersection(*(source.initial.edges for source in sources))
        edges = [number for number in sources[0].initial.edges if number in common]
        return _Graph(array("L", shared), array("L", self.ordered(edges)))

    def ordered(self, numbers: Iterable[int]) -> list[int]:
        """By source and relation; `ON` and `INSIDE` targets as given, others by ascending id."""

        def key(number: int) -> tuple[int, str, int]:
            source, relation, target = self.edges[number]
            return source, relation, 0 if relation in _ORDERED_RELATIONS else target

        return sorted(numbers, key=key)

    def delta(self, before: _Graph, after: _Graph, *, keep_order: bool) -> dict[str, list[int]]:
        """The difference; with `keep_order`, edges that would come out of order are moved to the end."""
        old = {self.objects[number].id: number for number in before.objects}
        new = {self.objects[number].id: number for number in after.objects}
        removed = set(before.edges).difference(after.edges)
        added = set(after.edges).difference(before.edges)
        if keep_order:
            moved = self.out_of_order(before, after, removed)
            removed |= moved & set(before.edges)
            added |= moved
        return {
            "removed_ids": [identifier for identifier in old if identifier not in new],
            "changed_objects": [number for key, number in new.items() if key in old and old[key] != number],
            "added_objects": [number for key, number in new.items() if key not in old],
            "removed_edges": self.flat(self.ordered(number for number in before.edges if number in removed)),
            "added_edges": self.flat(self.ordered(number for number in after.edges if number in added)),
        }

    def out_of_order(self, before: _Graph, after: _Graph, removed: set[int]) -> set[int]:
        """Ordered edges of `after` whose group is not: what stayed, in the old order, then what is new."""
        wanted = self.groups(after.edges)
        stayed = self.groups(number for number in before.edges if number not in removed)
        return {
            number
            for key, numbers in wanted.items()
            if stayed.get(key, []) != numbers[: len(stayed.get(key, []))]
            for number in numbers
        }

    def groups(self, numbers: Iterable[int]) -> dict[tuple[int, str], list[int]]:
        """(source, relation) -> edges, of the relations whose targets are ordered."""
        groups: dict[tuple[int, str], list[int]] = {}
        for number in numbers:
            source, relation, _ = self.edges[number]
            if relation in _ORDERED_RELATIONS:
                groups.setdefault((source, relation), []).append(number)
        return groups

    def task(self, source: _Source, base: _Graph) -> dict[str, object]:
        """The line of one task."""
        title, description, script = _script(source)
        nodes, edges = self.relevant(source.initial, source.final)
        goal = source.annotation["vh_goal"]
        states = [each for each in goal["goal"] if "state" in each]
        relations = [each for each in goal["goal"] if "relation_type" in each]
        return {
            "id": source.id,
            "title": title,
            "description": description,
            "script": script,
            "node_goals": [[each["id"], each["class_name"], each["state"]] for each in states],
            "edge_goals": [[each["from_id"], each["relation_type"], each["to_id"]] for each in relations],
            "action_goals": [each.split("|") for each in goal["actions"]],
            "tl_goal": source.annotation["tl_goal"],
            "initial": self.delta(base, source.initial, keep_order=True),
            "final": self.delta(source.initial, source.final, keep_order=False),
            "relevant_from_nodes": nodes,
            "relevant_from_edges": edges,
        }

    def relevant(self, initial: _Graph, final: _Graph) -> tuple[list[int], list[int]]:
        """Ids of the objects that differ, and the ends of the edges that differ, each in the order met."""
        nodes = _differing(initial.objects, final.objects)
        edges = _differing(initial.edges, final.edges)
        ends = (end for number in edges for end in self.edges[number][::2])
        return list(dict.fromkeys(self.objects[number].id for number in nodes)), list(dict.fromkeys(ends))


def _differing(before: Sequence[int], after: Sequence[int]) -> list[int]:
    """The members of only one of the two: first the lost, then the new."""
    old, new = set(before), set(after)
    return [each for each in before if each not in new] + [each for each in after if each not in old]


def _script(source: _Source) -> tuple[str, str, list[object]]:
    """Title, description and steps of a script file."""
    title, description, *lines = source.script.splitlines()
    if source.annotation.get("title", title) != title:
        raise DataError(f"script of {source.id}: its title is {title!r}, not {source.annotation['title']!r}")
    steps: list[object] = []
    for line in filter(None, map(str.strip, lines)):
        match = _STEP.fullmatch(line)
        if match is None:
            raise DataError(f"script of {source.id}: not a step: {line!r}")
        objects = [[name, int(number)] for name, number in _STEP_OBJECT.findall(match[2])]
        steps.append([match[1], objects])
    return title, description, steps
