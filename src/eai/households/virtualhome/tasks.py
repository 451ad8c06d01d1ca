"""VirtualHome tasks as states and goals, built from the records of the store on first use."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

from eai.abilities.task import Goal, GoalKind, Task
from eai.errors import DataError
from eai.households.virtualhome.predicates import PREDICATE_OF_RELATION, VOCABULARY
from eai.households.virtualhome.records import (
    CHARACTER_ID,
    Edge,
    GraphDelta,
    ObjectRecord,
    TaskRecord,
    VirtualHome,
    open_virtualhome,
)
from eai.logic.formula import Atom, Constant, Occurs, Or
from eai.tasks.source import Source, TaskSet
from eai.world.execution import Action
from eai.world.relation import Matrix, Relation
from eai.world.state import Draft, Scene, State, WorldObject

_BINARY = {name: VOCABULARY.binary_slots[stored] for name, stored in PREDICATE_OF_RELATION.items()}


class _Lines:
    """The rows and columns of all relations, and the masks of all unary predicates, while being built.

    ``described`` has the labels of each object. ``sources`` and ``targets`` are the masks of the objects
    whose row, or column, is not empty. ``relations`` are those that were made of all this and have not
    changed since: states share them.
    """

    def __init__(self, base: GraphDelta) -> None:
        self.objects: list[WorldObject] = []
        self.index: dict[int, int] = {}
        self.unary = [0] * len(VOCABULARY.unary_slots)
        self.described: list[frozenset[str]] = []
        self.rows: list[list[int]] = [[] for _ in VOCABULARY.binary_slots]
        self.columns: list[list[int]] = [[] for _ in VOCABULARY.binary_slots]
        self.sources = [0] * len(VOCABULARY.binary_slots)
        self.targets = [0] * len(VOCABULARY.binary_slots)
        self.relations: list[Relation | None] = [None] * len(VOCABULARY.binary_slots)
        self.apply(base)

    def copy(self) -> _Lines:
        """An independent copy."""
        twin = object.__new__(_Lines)
        twin.objects, twin.index, twin.unary = list(self.objects), dict(self.index), list(self.unary)
        twin.described = list(self.described)
        twin.rows = [list(rows) for rows in self.rows]
        twin.columns = [list(columns) for columns in self.columns]
        twin.sources, twin.targets = list(self.sources), list(self.targets)
        twin.relations = list(self.relations)
        return twin

    def append(self, records: Sequence[ObjectRecord]) -> None:
        """Add objects behind all others."""
        for record in records:
            self.index[record.id] = len(self.objects)
            self.objects.append(_world_object(record.class_name, record.id))
            self.described.append(frozenset())
        self._describe(records)
        if records:
            empty = [0] * len(records)
            for lines in (*self.rows, *self.columns):
                lines += empty
            self.relations = [None] * len(self.rows)

    def apply(self, delta: GraphDelta) -> None:
        """Make one graph into another.

        Raises:
            DataError: the delta removes objects, which no graph of the data set does.
        """
        if delta.removed_ids:
            raise DataError(f"objects {delta.removed_ids} vanish; run `eai data fetch --force`")
        self._describe(delta.changed_objects)
        self.append(delta.added_objects)
        self.link(delta.removed_edges, present=False)
        self.link(delta.added_edges, present=True)

    def link(self, edges: Iterable[Edge], *, present: bool) -> None:
        """Add or remove pairs of relations."""
        index, sources, targets = self.index, self.sources, self.targets
        for source_id, relation, target_id in edges:
            slot, source, target = _BINARY[relation], index[source_id], index[target_id]
            rows, columns = self.rows[slot], self.columns[slot]
            is_source, is_target = 1 << source, 1 << target
            self.relations[slot] = None
            if present:
                rows[source] |= is_target
                columns[target] |= is_source
                sources[slot] |= is_source
                targets[slot] |= is_target
                continue
            rows[source] &= ~is_target
            columns[target] &= ~is_source
            if not rows[source]:
                sources[slot] &= ~is_source
            if not columns[target]:
                targets[slot] &= ~is_target

    def _describe(self, records: Iterable[ObjectRecord]) -> None:
        """Set the category and every unary predicate of objects to what their records say."""
        objects, described, unary = self.objects, self.described, self.unary
        for record in records:
            index = self.index[record.id]
            if objects[index].category != record.class_name:
                objects[index] = _world_object(record.class_name, record.id)
            for slot in _differing(described[index], record.labels):
                unary[slot] ^= 1 << index
            described[index] = record.labels

    def state(self, scene: Scene) -> State:
        """The state over a scene of these objects."""
        return State(scene, tuple(self.unary), tuple(map(self._relation, range(len(self.relations)))))

    def after(self, state: State, delta: GraphDelta) -> State:
        """The state of these lines after a small difference; the lines stay as they are.

        Raises:
            DataError: the delta adds or removes objects, which no final graph of the data set does.
        """
        if delta.removed_ids or delta.added_objects:
            raise DataError("objects come or go in a plan; run `eai data fetch --force`")
        draft = Draft(state)
        for record in delta.changed_objects:
            index = self.index[record.id]
            for slot in _differing(self.described[index], record.labels):
                draft.unary[slot] ^= 1 << index
        for source, relation, target in delta.removed_edges:
            draft.unlink(_BINARY[relation], self.index[source], self.index[target])
        for source, relation, target in delta.added_edges:
            draft.link(_BINARY[relation], self.index[source], self.index[target])
        return State(state.scene, tuple(draft.unary), tuple(draft.binary))

    def _relation(self, slot: int) -> Relation:
        relation = self.relations[slot]
        if relation is None and not self.sources[slot]:
            return _empty(len(self.objects))
        if relation is None:
            matrix = Matrix(self.rows[slot], self.columns[slot], self.sources[slot], self.targets[slot])
            relation = self.relations[slot] = Relation(matrix)
        return relation


@dataclass(frozen=True, slots=True, kw_only=True)
class VirtualHomeTask(Task):
    """A task of VirtualHome, with the record of it that the data set has."""

    record: TaskRecord


VirtualHomeTasks: TypeAlias = TaskSet[VirtualHomeTask]


def build_tasks(records: VirtualHome) -> VirtualHomeTasks:
    """The tasks of the records."""
    base = _Lines(records.base)
    return TaskSet(records, lambda task_id: _task(records[task_id], base), records.sha256)


def _task(record: TaskRecord, base: _Lines) -> VirtualHomeTask:
    lines = base.copy()
    lines.apply(record.initial)
    scene = Scene(VOCABULARY, lines.objects, agent=lines.index[CHARACTER_ID])
    initial = lines.state(scene)
    index = lines.index
    return VirtualHomeTask(
        id=record.id,
        title=record.title,
        instruction=record.description,
        initial=initial,
        annotated_final=lines.after(initial, record.final),
        script=tuple(
            [Action(word, tuple([index[i] for _, i in objects])) for word, objects in record.script]
        ),
        goals=tuple(dict.fromkeys(_goals(record, scene, index))),
        temporal_goal=record.tl_goal,
        relevant=tuple(
            sorted({index[i] for i in (*record.relevant_from_nodes, *record.relevant_from_edges)})
        ),
        record=record,
    )


def open_tasks(source: Source | None = None) -> VirtualHomeTasks:
    """The VirtualHome tasks, fetched first when they are not there.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return build_tasks(open_virtualhome(source))


@cache
def _differing(before: frozenset[str], after: frozenset[str]) -> tuple[int, ...]:
    """The slots of the unary predicates that hold of an object with one of these sets of labels alone."""
    return tuple([VOCABULARY.unary_slots[name] for name in before ^ after])


@cache
def _empty(size: int) -> Relation:
    """The relation of no two of so many objects; states share it."""
    nothing = (0,) * size
    return Relation(Matrix(nothing, nothing, 0, 0))


@cache
def _world_object(class_name: str, object_id: int) -> WorldObject:
    return WorldObject(f"{class_name}.{object_id}", class_name)


def _goals(record: TaskRecord, scene: Scene, index: Mapping[int, int]) -> Iterable[Goal]:
    def constant(object_id: int) -> Constant:
        return Constant(scene.objects[index[object_id]].name)

    for number, _, state in record.node_goals:
        yield Goal(GoalKind.STATE, Atom(state, (constant(number),)))
    for source, relation, target in record.edge_goals:
        predicate = PREDICATE_OF_RELATION[relation]
        yield Goal(GoalKind.RELATION, Atom(predicate, (constant(source), constant(target))))
    for alternatives in record.action_goals:
        yield Goal(GoalKind.ACTION, Or(tuple(Occurs(word) for word in alternatives)))
