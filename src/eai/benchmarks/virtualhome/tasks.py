"""VirtualHome tasks as states and goals, built from the stored data on first use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from eai.base.errors import DataError
from eai.benchmarks.virtualhome.predicates import PREDICATE_OF_RELATION, VOCABULARY
from eai.benchmarks.virtualhome.records import (
    CHARACTER_ID,
    GraphDelta,
    SceneObjectRecord,
    TaskRecord,
    VirtualHomeRecords,
    open_records,
)
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.relation import InitialRelation, ObjectMask, Relation
from eai.world.state import Scene, State, StateDraft, WorldObject

_UNARY = VOCABULARY.unary_slots
_UNLABELLED = frozenset[str]()
_BINARY = {name: VOCABULARY.binary_slots[stored] for name, stored in PREDICATE_OF_RELATION.items()}


@dataclass(frozen=True, slots=True)
class _SceneGraphAsBitMasks:
    """A graph of the data set with objects numbered by position.

    Attributes:
        objects: the objects, in order of position.
        labels: object id -> labels (properties and states) of the object.
        index: object id -> position of the object.
        unary: for each unary predicate, a bit mask of the objects for which it holds.
        rows: for each relation and source, a bit mask of targets.
        columns: for each relation and target, a bit mask of sources.
        ends: for each relation, a bit mask of all sources and a bit mask of all targets.
    """

    objects: Sequence[WorldObject]
    labels: Mapping[int, frozenset[str]]
    index: Mapping[int, int]
    unary: Sequence[int]
    rows: Sequence[Sequence[int]]
    columns: Sequence[Sequence[int]]
    ends: Sequence[tuple[int, int]]

    def apply_delta(self, delta: GraphDelta) -> _SceneGraphAsBitMasks:
        """Return a copy of the graph with the changes of a delta (difference of two graphs).

        Raises:
            DataError: the delta removes objects. No delta of the data set does so.
        """
        if delta.removed_ids:
            raise DataError(
                "the data set is damaged: a task's initial graph lacks the shared objects "
                f"{delta.removed_ids}; run `eai data fetch --force`"
            )
        described = (*delta.changed_objects, *delta.added_objects)
        labels = {**self.labels, **{record.id: record.properties_and_states for record in described}}
        index = {
            **self.index,
            **{record.id: i for i, record in enumerate(delta.added_objects, len(self.objects))},
        }
        empty = [0] * len(delta.added_objects)
        objects = [
            *self.objects,
            *[_make_object(record.class_name, record.id) for record in delta.added_objects],
        ]
        for record in delta.changed_objects:
            objects[index[record.id]] = _make_object(record.class_name, record.id)
        rows, columns = ([[*lines, *empty] for lines in table] for table in (self.rows, self.columns))
        for source_id, relation, target_id in delta.removed_edges:
            slot, source, target = _BINARY[relation], index[source_id], index[target_id]
            rows[slot][source] &= ~(1 << target)
            columns[slot][target] &= ~(1 << source)
        ends = list(self.ends)
        for source_id, relation, target_id in delta.added_edges:
            slot, source, target = _BINARY[relation], index[source_id], index[target_id]
            rows[slot][source] |= 1 << target
            columns[slot][target] |= 1 << source
            ends[slot] = ends[slot][0] | 1 << source, ends[slot][1] | 1 << target
        unary = list(self.unary)
        self._update_object_masks_of_unary_predicates(unary, described, index)
        return _SceneGraphAsBitMasks(objects, labels, index, unary, rows, columns, ends)

    def _update_object_masks_of_unary_predicates(
        self,
        unary_masks: list[ObjectMask],
        records: Iterable[SceneObjectRecord],
        index_by_id: Mapping[int, int],
    ) -> None:
        """Update the bit masks of unary predicates for new objects and for objects that changed.

        An object changed if its properties or states (its labels) differ.
        """
        for record in records:
            bit = 1 << index_by_id[record.id]
            for slot in _find_indices_of_changed_unary_predicates(
                self.labels.get(record.id, _UNLABELLED), record.properties_and_states
            ):
                unary_masks[slot] ^= bit

    def to_state(self) -> State:
        """Return the state of all objects, including the character."""
        relations = tuple(map(_make_relation_from_bit_masks, self.rows, self.columns, self.ends))
        return State(Scene(VOCABULARY, self.objects, self.index[CHARACTER_ID]), tuple(self.unary), relations)

    def apply_delta_to_state(self, state: State, delta: GraphDelta) -> State:
        """Return a state of this graph with the changes of a delta. This is fast if there are few changes.

        Raises:
            DataError: the delta adds or removes objects. No final graph of the data set does so.
        """
        if delta.removed_ids or delta.added_objects:
            raise DataError(
                "the data set is damaged: the final graph of a task adds or removes objects; run "
                "`eai data fetch --force`"
            )
        draft, index = StateDraft(state), self.index
        self._update_object_masks_of_unary_predicates(draft.unary, delta.changed_objects, index)
        for source, relation, target in delta.removed_edges:
            draft.set_binary_fact(_BINARY[relation], index[source], index[target], False)
        for source, relation, target in delta.added_edges:
            draft.set_binary_fact(_BINARY[relation], index[source], index[target], True)
        return State(state.scene, tuple(draft.unary), tuple(draft.binary))


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualHomeTask(Task):
    """A task of VirtualHome, with the published data (record) from which it was made."""

    record: TaskRecord


VirtualHomeTasks: TypeAlias = TaskSet[VirtualHomeTask]


def build_tasks(records: VirtualHomeRecords) -> VirtualHomeTasks:
    """Return VirtualHome's tasks, made from the published data of each task (record)."""
    nothing = [()] * len(VOCABULARY.binary_slots)
    empty = _SceneGraphAsBitMasks((), {}, {}, [0] * len(_UNARY), nothing, nothing, [(0, 0)] * len(nothing))
    base = empty.apply_delta(records.base)
    return TaskSet(records, lambda task_id: _build_task(records[task_id], base), records.sha256)


def _build_task(record: TaskRecord, base: _SceneGraphAsBitMasks) -> VirtualHomeTask:
    graph = base.apply_delta(record.initial)
    initial, index = graph.to_state(), graph.index
    return VirtualHomeTask(
        id=record.id,
        title=record.title,
        instruction=record.description,
        initial=initial,
        annotated_final=graph.apply_delta_to_state(initial, record.final),
        script=tuple(
            [Action(word, tuple([index[i] for _, i in objects])) for word, objects in record.script]
        ),
        goals=tuple(dict.fromkeys(_yield_goals(record, initial.scene, index))),
        temporal_goal=record.tl_goal,
        relevant=tuple(
            sorted({index[i] for i in (*record.relevant_from_nodes, *record.relevant_from_edges)})
        ),
        record=record,
    )


def open_tasks(source: Source | None = None) -> VirtualHomeTasks:
    """Return the VirtualHome tasks; download them first if they are missing.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return build_tasks(open_records(source))


@cache
def _find_indices_of_changed_unary_predicates(
    labels_before: frozenset[str], labels_after: frozenset[str]
) -> Sequence[int]:
    """Return the indices of the unary predicates (properties and states) that are in only one of two sets."""
    return [_UNARY[name] for name in labels_before ^ labels_after]


def _make_relation_from_bit_masks(
    target_mask_by_source: Sequence[ObjectMask],
    source_mask_by_target: Sequence[ObjectMask],
    source_and_target_masks: tuple[ObjectMask, ObjectMask],
) -> Relation:
    if source_and_target_masks[0]:
        return Relation(
            InitialRelation(target_mask_by_source, source_mask_by_target, *source_and_target_masks)
        )
    return _make_empty_relation(len(target_mask_by_source))


@cache
def _make_empty_relation(size: int) -> Relation:
    """Return the empty relation for states with `size` objects. All these states share it."""
    return Relation(InitialRelation([0] * size, [0] * size))


@cache
def _make_object(class_name: str, object_id: int) -> WorldObject:
    return WorldObject(f"{class_name}.{object_id}", class_name)


def _yield_goals(record: TaskRecord, scene: Scene, index: Mapping[int, int]) -> Iterable[Goal]:
    def make_constant(object_id: int) -> Constant:
        return Constant(scene.objects[index[object_id]].name)

    for number, _, state in record.node_goals:
        yield Goal(GoalKind.STATE, Atom(state, (make_constant(number),)))
    for source, relation, target in record.edge_goals:
        predicate = PREDICATE_OF_RELATION[relation]
        yield Goal(GoalKind.RELATION, Atom(predicate, (make_constant(source), make_constant(target))))
    for alternatives in record.action_goals:
        yield Goal(GoalKind.ACTION, Or(tuple(Occurs(word) for word in alternatives)))
