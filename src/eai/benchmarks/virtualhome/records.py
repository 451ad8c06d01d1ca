"""The published data of VirtualHome's tasks (records), without interpretation.

Records are read from the data store. A task is one line of text, decoded on first use. The scene is stored
once. A task stores the difference of its initial graph from the scene, and the difference of its final graph
from its initial graph.

Objects ascend by id, as in every initial graph of the data set. The edges of one source with the relation
`ON` or `INSIDE` keep the order of the data set's file, because the paper's package takes the first edge.
Edges of other relations ascend by ids.
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
"""Category of nodes that are rooms."""

PACK = "virtualhome"
"""Name of the data package (pack) with the published data of VirtualHome."""

TASKS_MEMBER = "tasks.jsonl"
"""Name of the file of tasks in the data package `PACK`.

The first line has the base scene, and tables of objects and relations. Each other line is a task, which
refers to these by number and stores only its differences from the base scene.
"""


Edge: TypeAlias = tuple[int, str, int]
"""An edge of a scene graph: source id, relation, target id. Tuples save time, as a scene has 5,700 edges."""


@dataclass(frozen=True)
class SceneObjectRecord:
    """An object of a graph; `properties` and `states` are sorted and without duplicates."""

    id: int
    class_name: str
    category: str
    properties: tuple[str, ...]
    states: tuple[str, ...]

    @cached_property
    def properties_and_states(self) -> frozenset[str]:
        """Properties and states of the object, and ``ROOM`` if it is a room."""
        room = ("ROOM",) if self.category == _ROOMS else ()
        return frozenset((*self.properties, *self.states, *room))


@dataclass(frozen=True, slots=True)
class GraphDelta:
    """The difference of two scene graphs: first remove, then replace, then append objects and edges.

    Each list is applied in its own order. An `ON` or `INSIDE` edge that is listed in both `removed_edges` and
    `added_edges` only changes its position in the graph: it is then the last edge of its source and relation.
    """

    removed_ids: tuple[int, ...]
    changed_objects: tuple[SceneObjectRecord, ...]
    added_objects: tuple[SceneObjectRecord, ...]
    removed_edges: tuple[Edge, ...]
    added_edges: tuple[Edge, ...]


@dataclass(frozen=True, slots=True)
class TaskRecord:
    """A task as the data set annotates it. Goals keep their order and duplicates.

    Attributes:
        id: the data set's id, such as `27_2`, without the prefix `scene_1_` of the subgoal files.
        title: the name that similar tasks have in common, such as `Wash clothes`.
        description: the natural-language instruction.
        script: the annotated (gold) plan: an action for each step, with class name and id of its objects.
        node_goals: required states: id and class name of an object, and the state.
        edge_goals: required relations of two objects.
        action_goals: actions to be taken. Each goal lists actions, such as `LOOKAT` and `WATCH`. Any one of
            them reaches the goal.
        tl_goal: the goal as a temporal-logic text; None for the four tasks without goals.
        initial: the difference from the base scene to the initial graph.
        final: the difference from the initial to the final graph.
        relevant_from_nodes: ids of objects that differ between initial and final graph, without duplicates,
            in the order of the initial graph. The paper's package calls the objects of this and the next
            attribute relevant.
        relevant_from_edges: ids at the ends of edges that differ, without duplicates, in order of occurrence:
            source before target, edges of the initial graph before those of the final graph, each in file
            order.
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
    def relevant_object_ids(self) -> list[int]:
        """Ids of the relevant objects, in the order of the Python sets in the paper's package.

        The hash of a small integer is the integer itself, so this order depends only on the ids.
        """
        of_nodes = set(self.relevant_from_nodes)
        return list(of_nodes | (set(self.relevant_from_edges) - of_nodes))


class _ObjectAndRelationTables(NamedTuple):
    """Tables of objects and relations for all tasks. The record of a task has indices into these tables."""

    relations: Sequence[str]
    records: Sequence[SceneObjectRecord]

    def get_objects(self, indices: Iterable[int]) -> tuple[SceneObjectRecord, ...]:
        return tuple(map(self.records.__getitem__, indices))

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
        """Return the published data of a task from the JSON value of its line."""
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


class VirtualHomeRecords(TaskSet[TaskRecord]):
    """Published data of tasks (records) by task id, in data set order. Each is decoded once, on first use.

    Attributes:
        base: the base scene, as a difference from an empty graph. It has the objects and edges that the
            initial graphs of all tasks have in common, and the most frequent properties and states of each
            object. The record of a task lists objects that differ from these.
    """

    def __init__(self, content: bytes, sha256: str) -> None:
        header, *lines = content.splitlines()
        values = json.loads(header)
        labels = list(map(tuple, values["labels"]))
        records = [
            SceneObjectRecord(number, name, category, labels[owned], labels[state])
            for number, name, category, owned, state in values["objects"]
        ]
        tables = _ObjectAndRelationTables(values["relations"], records)
        objects, edges = tables.get_objects(values["base_objects"]), tables.read_edges(values["base_edges"])
        self.base = GraphDelta((), (), objects, (), edges)
        texts = dict(zip(values["tasks"], lines, strict=True))
        super().__init__(texts, lambda task_id: tables.read_task(json.loads(texts[task_id])), sha256)

    @classmethod
    def from_pack(cls, pack: PackFile) -> VirtualHomeRecords:
        """Return the published data (records) in the data package (pack) of VirtualHome."""
        return cls(pack.read_member(TASKS_MEMBER), pack.sha256)


CHARACTER_ID = 65
"""Id of the acting character in every VirtualHome graph of the data set."""


def open_records(source: Source | None = None) -> VirtualHomeRecords:
    """Return the published data (records) of VirtualHome's tasks; download it first if it is missing.

    Raises:
        DataError: the data cannot be obtained, or the store is damaged.
    """
    return VirtualHomeRecords.from_pack(open_pack(PACK, source))
