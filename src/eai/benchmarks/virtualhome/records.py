"""The VirtualHome data set as plain records: no world state, no check, no interpretation.

They are read from the store, where a task is one text line that is decoded on first use. A scene is
stored once; a task says how its own initial graph differs from it, and how its final graph differs from the
initial one.

Order: objects come by ascending id, which is their order in every initial graph of the data set. The targets
of one source under `ON` or `INSIDE` keep the order of the data set's file, because the reference asks for the
first of them; edges of other relations come by ascending ids.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

from eai.base.store import PackFile
from eai.benchmarks.packs import open_pack
from eai.tasks.source import Source, TaskSet

_ROOMS = "Rooms"
"""The category of nodes that are rooms."""

PACK = "virtualhome"
"""Name of the pack with the records of VirtualHome."""

TASKS_MEMBER = "tasks.jsonl"
"""Line 1: the tables and the base scene; then one line a task, in data set order."""


Edge: TypeAlias = tuple[int, str, int]
"""A source, a relation in which it stands, and the target, both object ids. A tuple, as a scene has 5,700."""


@dataclass(frozen=True)
class ObjectRecord:
    """One object of a graph; `properties` and `states` are sorted and without duplicates."""

    id: int
    class_name: str
    category: str
    properties: tuple[str, ...]
    states: tuple[str, ...]

    @cached_property
    def labels(self) -> frozenset[str]:
        """All that is said of it alone: its properties and states, and whether it is a room."""
        room = ("ROOM",) if self.category == _ROOMS else ()
        return frozenset((*self.properties, *self.states, *room))


@dataclass(frozen=True, slots=True)
class GraphDelta:
    """The difference of two graphs: take away, then replace, then append, each in order.

    An edge may be in both `removed_edges` and `added_edges`: it then moves to the end of its source's
    `ON` or `INSIDE` targets.
    """

    removed_ids: tuple[int, ...]
    changed_objects: tuple[ObjectRecord, ...]
    added_objects: tuple[ObjectRecord, ...]
    removed_edges: tuple[Edge, ...]
    added_edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """One task as the data set annotates it. Goals keep its order and its duplicates.

    Attributes:
        id: the data set's id, such as `27_2`, without the subgoal files' `scene_1_` prefix.
        title: the name that tasks of a kind share, such as `Wash clothes`.
        description: the natural-language instruction.
        script: the annotated (gold) steps: each an action, and the objects by class name, as written, and id.
        node_goals: the objects, by id and class name, that shall be in a state.
        edge_goals: the relations in which two objects shall stand.
        action_goals: the alternatives one of which shall be done, such as `LOOKAT` or `WATCH`.
        tl_goal: the goal as a temporal-logic text; None for the four tasks without goals.
        initial: how the initial graph differs from the base scene.
        final: how the final graph differs from the initial one.
        relevant_from_nodes: ids of objects that differ between the two graphs, without duplicates, in the
            order of the initial graph. The reference calls these, and the next, the relevant objects.
        relevant_from_edges: ends of the edges that differ, without duplicates, in the order met: source
            before target, the initial graph's edges before the final graph's, each in file order.
    """

    id: str
    title: str
    description: str
    script: tuple[tuple[str, tuple[tuple[str, int], ...]], ...]
    node_goals: tuple[tuple[int, str, str], ...]
    edge_goals: tuple[Edge, ...]
    action_goals: tuple[tuple[str, ...], ...]
    tl_goal: str | None
    initial: GraphDelta
    final: GraphDelta
    relevant_from_nodes: tuple[int, ...]
    relevant_from_edges: tuple[int, ...]

    @property
    def relevant_in_order(self) -> list[int]:
        """The ids of the objects that it is about, in the order of the Python sets that the reference has.

        The hash of a small integer is the integer itself: the order is a function of the ids alone.
        """
        of_nodes = set(self.relevant_from_nodes)
        return list(of_nodes | (set(self.relevant_from_edges) - of_nodes))


class _LineTables(NamedTuple):
    """Tables to which the task lines refer by number."""

    relations: Sequence[str]
    records: Sequence[ObjectRecord]

    def get_objects(self, numbers: Iterable[int]) -> tuple[ObjectRecord, ...]:
        return tuple(map(self.records.__getitem__, numbers))

    def read_edges(self, flat: Sequence[int]) -> tuple[Edge, ...]:
        relations = map(self.relations.__getitem__, flat[1::3])
        return tuple(zip(flat[::3], relations, flat[2::3], strict=True))

    def read_delta(self, values: Mapping[str, Any]) -> GraphDelta:
        return GraphDelta(
            removed_ids=tuple(values["removed_ids"]),
            changed_objects=self.get_objects(values["changed_objects"]),
            added_objects=self.get_objects(values["added_objects"]),
            removed_edges=self.read_edges(values["removed_edges"]),
            added_edges=self.read_edges(values["added_edges"]),
        )

    def read_task(self, values: Mapping[str, Any]) -> TaskRecord:
        """The record of a line, whose members are those of a record."""
        flat = ("relevant_from_nodes", "relevant_from_edges")
        nested = ("node_goals", "edge_goals", "action_goals")
        read: dict[str, Any] = {
            "script": tuple([(word, tuple(map(tuple, objects))) for word, objects in values["script"]]),
            "initial": self.read_delta(values["initial"]),
            "final": self.read_delta(values["final"]),
            **{name: tuple(values[name]) for name in flat},
            **{name: tuple(map(tuple, values[name])) for name in nested},
        }
        return TaskRecord(**{**values, **read})


class VirtualHome(TaskSet[TaskRecord]):
    """Task id -> record, in data set order; a record is decoded once, on first use.

    Attributes:
        base: what all initial graphs share, as the difference from no graph: every id that occurs in all of
            them, with its most frequent record, and every edge that does. A task whose object differs lists
            it as changed.
    """

    def __init__(self, content: bytes, sha256: str) -> None:
        header, *lines = content.splitlines()
        values = json.loads(header)
        labels = list(map(tuple, values["labels"]))
        records = [
            ObjectRecord(number, name, category, labels[owned], labels[state])
            for number, name, category, owned, state in values["objects"]
        ]
        tables = _LineTables(values["relations"], records)
        objects, edges = tables.get_objects(values["base_objects"]), tables.read_edges(values["base_edges"])
        self.base = GraphDelta((), (), objects, (), edges)
        texts = dict(zip(values["tasks"], lines, strict=True))
        super().__init__(texts, lambda task_id: tables.read_task(json.loads(texts[task_id])), sha256)

    @classmethod
    def of(cls, pack: PackFile) -> VirtualHome:
        """The tasks of a pack."""
        return cls(pack.read(TASKS_MEMBER), pack.sha256)


CHARACTER_ID = 65
"""Id of the acting character in every VirtualHome graph of the data set."""


def open_virtualhome(source: Source | None = None) -> VirtualHome:
    """The records of the VirtualHome tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return VirtualHome.of(open_pack(PACK, source))
