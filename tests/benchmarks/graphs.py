"""Applies the stored differences of graphs, as readers of the records must."""

from __future__ import annotations

from dataclasses import dataclass

from eai.benchmarks.virtualhome.records import Edge, GraphDelta, SceneObjectRecord, TaskRecord

ORDERED = ("ON", "INSIDE")


@dataclass(frozen=True)
class PlainGraph:
    objects: dict[int, SceneObjectRecord]
    edges: list[Edge]

    def targets(self) -> dict[tuple[int, str], list[int]]:
        """Return the targets by source and relation, in the order that the records promise."""
        groups: dict[tuple[int, str], list[int]] = {}
        for source, relation, target in self.edges:
            groups.setdefault((source, relation), []).append(target)
        return {key: ids if key[1] in ORDERED else sorted(ids) for key, ids in groups.items()}


def apply_delta(graph: PlainGraph, delta: GraphDelta) -> PlainGraph:
    objects = {key: record for key, record in graph.objects.items() if key not in delta.removed_ids}
    assert set(delta.removed_ids) <= graph.objects.keys()
    assert {record.id for record in delta.changed_objects} <= objects.keys()
    assert not {record.id for record in delta.added_objects} & objects.keys()
    objects |= {record.id: record for record in (*delta.changed_objects, *delta.added_objects)}
    assert set(delta.removed_edges) <= set(graph.edges)
    remaining = [edge for edge in graph.edges if edge not in set(delta.removed_edges)]
    assert not set(remaining) & set(delta.added_edges)
    return PlainGraph(objects, [*remaining, *delta.added_edges])


def build_initial_graph(base: GraphDelta, task: TaskRecord) -> PlainGraph:
    return apply_delta(apply_delta(PlainGraph({}, []), base), task.initial)


def build_final_graph(base: GraphDelta, task: TaskRecord) -> PlainGraph:
    return apply_delta(build_initial_graph(base, task), task.final)
