"""Applies the differences that the store holds: what a reader of the records has to do."""

from __future__ import annotations

from dataclasses import dataclass

from eai.benchmarks.virtualhome.records import Edge, GraphDelta, ObjectRecord, TaskRecord

ORDERED = ("ON", "INSIDE")


@dataclass(frozen=True)
class PlainGraph:
    objects: dict[int, ObjectRecord]
    edges: list[Edge]

    def targets(self) -> dict[tuple[int, str], list[int]]:
        """(source, relation) -> targets, in the order that the records promise."""
        groups: dict[tuple[int, str], list[int]] = {}
        for source, relation, target in self.edges:
            groups.setdefault((source, relation), []).append(target)
        return {key: ids if key[1] in ORDERED else sorted(ids) for key, ids in groups.items()}


def changed(graph: PlainGraph, delta: GraphDelta) -> PlainGraph:
    objects = {key: record for key, record in graph.objects.items() if key not in delta.removed_ids}
    assert set(delta.removed_ids) <= graph.objects.keys()
    assert {record.id for record in delta.changed_objects} <= objects.keys()
    assert not {record.id for record in delta.added_objects} & objects.keys()
    objects |= {record.id: record for record in (*delta.changed_objects, *delta.added_objects)}
    assert set(delta.removed_edges) <= set(graph.edges)
    kept = [edge for edge in graph.edges if edge not in set(delta.removed_edges)]
    assert not set(kept) & set(delta.added_edges)
    return PlainGraph(objects, [*kept, *delta.added_edges])


def initial_graph(base: GraphDelta, task: TaskRecord) -> PlainGraph:
    return changed(changed(PlainGraph({}, []), base), task.initial)


def final_graph(base: GraphDelta, task: TaskRecord) -> PlainGraph:
    return changed(initial_graph(base, task), task.final)
