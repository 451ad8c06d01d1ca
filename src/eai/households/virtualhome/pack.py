"""The VirtualHome tasks, read from the store: one text line a task, decoded when it is asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import starmap
from typing import Any

from eai.data.store import PackFile
from eai.households.virtualhome.records import (
    ActionGoal,
    BaseScene,
    Edge,
    EdgeGoal,
    GraphDelta,
    NodeGoal,
    ObjectRecord,
    ScriptObject,
    ScriptStep,
    TaskRecord,
)

PACK = "virtualhome"
"""Name of the pack with what scoring needs."""

TASKS_MEMBER = "tasks.jsonl"
"""Line 1: the tables and the base scene; then one line a task, in data set order."""


@dataclass(frozen=True, slots=True)
class _Tables:
    """What the task lines refer to by number."""

    relations: Sequence[str]
    labels: Sequence[tuple[str, ...]]
    rows: Sequence[Sequence[Any]]
    records: dict[int, ObjectRecord] = field(default_factory=dict)

    def object(self, number: int) -> ObjectRecord:
        identifier, class_name, category, properties, states = self.rows[number]
        labels = self.labels
        record = ObjectRecord(identifier, class_name, category, labels[properties], labels[states])
        return self.records.setdefault(number, record)

    def objects(self, numbers: Sequence[int]) -> tuple[ObjectRecord, ...]:
        known = self.records.get
        return tuple([known(number) or self.object(number) for number in numbers])

    def edges(self, flat: Sequence[int]) -> tuple[Edge, ...]:
        relations = map(self.relations.__getitem__, flat[1::3])
        return tuple(starmap(Edge, zip(flat[::3], relations, flat[2::3], strict=True)))

    def delta(self, values: Mapping[str, Any]) -> GraphDelta:
        return GraphDelta(
            removed_ids=tuple(values["removed_ids"]),
            changed_objects=self.objects(values["changed_objects"]),
            added_objects=self.objects(values["added_objects"]),
            removed_edges=self.edges(values["removed_edges"]),
            added_edges=self.edges(values["added_edges"]),
        )

    def task(self, values: Mapping[str, Any]) -> TaskRecord:
        return TaskRecord(
            id=values["id"],
            title=values["title"],
            description=values["description"],
            script=tuple(starmap(_step, values["script"])),
            node_goals=tuple(starmap(NodeGoal, values["node_goals"])),
            edge_goals=tuple(starmap(EdgeGoal, values["edge_goals"])),
            action_goals=tuple(ActionGoal(tuple(words)) for words in values["action_goals"]),
            tl_goal=values["tl_goal"],
            initial=self.delta(values["initial"]),
            final=self.delta(values["final"]),
            relevant_from_nodes=tuple(values["relevant_from_nodes"]),
            relevant_from_edges=tuple(values["relevant_from_edges"]),
        )


def _step(action: str, objects: Sequence[tuple[str, int]]) -> ScriptStep:
    return ScriptStep(action, tuple(starmap(ScriptObject, objects)))


class VirtualHome(Mapping[str, TaskRecord]):
    """Task id -> record, in data set order; a record is decoded once, on first use.

    Attributes:
        base: what all initial graphs share.
        sha256: digest of the data, to be recorded with every result made from it.
    """

    def __init__(self, content: bytes, sha256: str) -> None:
        header, *lines = content.splitlines()
        values = json.loads(header)
        self.sha256 = sha256
        self._tables = _Tables(values["relations"], tuple(map(tuple, values["labels"])), values["objects"])
        self.base = BaseScene(
            self._tables.objects(values["base_objects"]), self._tables.edges(values["base_edges"])
        )
        self._lines = dict(zip(values["tasks"], lines, strict=True))
        self._decoded: dict[str, TaskRecord] = {}

    @classmethod
    def of(cls, pack: PackFile) -> VirtualHome:
        """The tasks of a pack."""
        return cls(pack.read(TASKS_MEMBER), pack.manifest.sha256)

    def __getitem__(self, task_id: str) -> TaskRecord:
        record = self._decoded.get(task_id)
        if record is None:
            record = self._tables.task(json.loads(self._lines[task_id]))
            self._decoded[task_id] = record
        return record

    def __iter__(self) -> Iterator[str]:
        return iter(self._lines)

    def __len__(self) -> int:
        return len(self._lines)
