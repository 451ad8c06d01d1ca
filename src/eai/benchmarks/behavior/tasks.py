"""BEHAVIOR tasks as states and goals, built on first use.

They are built from the published files, and from facts that no published file states (module `evidence`).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from eai.benchmarks.behavior import predicates as p
from eai.benchmarks.behavior.evidence import GroundRelation, UnpublishedSceneFacts, load_unpublished_facts
from eai.benchmarks.behavior.predicates import VOCABULARY
from eai.benchmarks.behavior.records import PACK, BehaviorRecord, read_records
from eai.benchmarks.packs import open_pack
from eai.logic.formula import And, Formula, get_operands
from eai.logic.rewriting import rename_objects
from eai.logic.traversal import find_predicates
from eai.tasks.source import Source, TaskSet
from eai.tasks.task import Goal, GoalKind, Task
from eai.world.action import Action
from eai.world.state import Fact, Scene, State, WorldObject

MAX_GRASPABLE_VOLUME = 1.5
"""Maximum volume of an object that a hand can grasp, in m3 (``evolving_graph.py`` of the paper's package)."""

MUCH_LARGER_RATIO = 5
"""Ratio of the volumes of an object and its support, above which the object falls off a grasped support.

The number is from ``evolving_graph.py`` of the paper's package.
"""

_ABILITY_PREDICATES: Mapping[str, str] = {
    **{ability.name: ability.name for ability, _ in p.STATES},
    "slicer": p.slicer.name,
    "cleaningTool": p.cleaning_tool.name,
    "coldSource": p.cold_source.name,
}
"""Ability of objects in the data set's taxonomy -> predicate of the domain.

The mapping lacks abilities that the domain does not use.
"""

_MODEL_CATEGORY_PREDICATES = {kind.name for kind in (p.sink, p.dishwasher, p.teapot, p.saucepan, p.detergent)}
"""Names of predicates that tell the category of an object's 3D model, such as ``sink``.

Actions depend on these predicates. A name is equal to the name of the model category.
"""

RELATIONS = frozenset(p.STORED)
"""Names of BDDL's relations. All other predicates of BDDL are states of one object."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BehaviorTask(Task):
    """A task of BEHAVIOR, with the published data (record) from which the task was made.

    Attributes:
        record: the task as published; its problem names objects by instance, as in ``rag.n.01_1``.
        initial_as_published: the initial state that reproduces the published verdicts on subgoals. It has the
            same scene as `initial`, and for most tasks is `initial` itself.
    """

    record: BehaviorRecord
    initial_as_published: State


BehaviorTasks: TypeAlias = TaskSet[BehaviorTask]


def build_tasks(records: TaskSet[BehaviorRecord], unpublished_facts: UnpublishedSceneFacts) -> BehaviorTasks:
    """Return BEHAVIOR's tasks, made from published data (records) and unpublished facts (evidence).

    The digest of the tasks covers both.
    """
    sha256 = hashlib.sha256(f"{records.sha256}{unpublished_facts.sha256}".encode()).hexdigest()
    return TaskSet(records, lambda task_id: build_task(records[task_id], unpublished_facts), sha256)


def build_task(record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts) -> BehaviorTask:
    """Return the task made from its published data (record) and unpublished facts (evidence).

    Args:
        record: the facts of published files.
        unpublished_facts: the facts that no published file states.
    """
    builder = _BehaviorTaskBuilder(record, unpublished_facts)
    initial = builder.build_state(collect_initial_relations(record, unpublished_facts))
    as_published = record.id in unpublished_facts.listed_relations_only
    return BehaviorTask(
        id=record.id,
        title=record.activity,
        instruction=record.instruction,
        initial=initial,
        annotated_final=None,
        script=tuple(builder.yield_human_plan()),
        goals=tuple(builder.yield_goals()),
        temporal_goal=None,
        relevant=tuple(range(len(builder.scene.objects))),
        record=record,
        initial_as_published=builder.build_state(read_initial_relations(record)) if as_published else initial,
    )


def open_tasks(source: Source | None = None) -> BehaviorTasks:
    """Return the BEHAVIOR tasks; download them first if they are missing.

    Raises:
        DataError: they cannot be obtained, or the store is damaged.
    """
    return build_tasks(read_records(open_pack(PACK, source)), load_unpublished_facts())


def collect_initial_relations(
    record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts
) -> tuple[GroundRelation, ...]:
    """Return the initial relations of a task, with object names of the scene.

    The relations come from the problem file, from assumptions about furniture, and from unpublished facts.
    """
    listed = read_initial_relations(record)
    removed = unpublished_facts.removed.get(record.id, ())
    remaining = tuple(relation for relation in listed if relation[:2] not in removed)
    return (
        *remaining,
        *assume_furniture_on_floor(record, unpublished_facts),
        *unpublished_facts.added.get(record.id, ()),
    )


def read_initial_relations(record: BehaviorRecord) -> tuple[GroundRelation, ...]:
    """Return the initial relations in a problem file, except the robot's, with object names of the scene."""
    name_of = {obj.instance: obj.name for obj in record.objects}
    return tuple(
        (fact.predicate, name_of[source.name], name_of[target.name])
        for fact in record.problem.initial
        if fact.predicate in RELATIONS
        for source, target in (fact.arguments,)
        if source.name in name_of and target.name in name_of
    )


def assume_furniture_on_floor(
    record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts
) -> tuple[GroundRelation, ...]:
    """Return relations that put furniture on the floor of its room, if the problem file does not place it."""
    stated = [fact for fact in record.problem.initial if fact.predicate == "inroom"]
    rooms = {fact.arguments[0].name: fact.arguments[1].name for fact in stated}
    floors = {
        rooms[obj.instance]: obj.name for obj in record.objects if obj.is_floor and obj.instance in rooms
    }
    listed = read_initial_relations(record)
    placed = {source for predicate, source, _ in listed if predicate in ("inside", "ontop", "onfloor")}
    return tuple(
        ("onfloor", obj.name, floors[rooms[obj.instance]])
        for obj in record.objects
        if obj.model in unpublished_facts.standing
        and obj.name not in placed
        and rooms.get(obj.instance) in floors
    )


def yield_initial_states_of_objects(
    record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts
) -> Iterator[tuple[str, str]]:
    """Yield the initial states of objects, each as a pair of a predicate and the object's name."""
    name_of = {obj.instance: obj.name for obj in record.objects}
    for fact in record.problem.initial:
        if len(fact.arguments) == 1 and fact.arguments[0].name in name_of:
            yield fact.predicate, name_of[fact.arguments[0].name]
    for obj in record.objects:
        if obj.model in unpublished_facts.initially_open and "open" in obj.possible_states:
            yield "open", obj.name


def estimate_object_volumes(record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts) -> list[float]:
    """Return the estimated volume in cubic metres of each object in the scene of a task."""
    estimates = unpublished_facts.volumes
    volumes = [estimates.get_volume(record.scene, obj.name, obj.model) for obj in record.objects]
    for obj, volume in zip(record.objects, tuple(volumes), strict=True):
        volumes += [estimates.ratio_of_half * volume] * len(obj.names_of_sliced_halves)
    return volumes


def _compare_volumes(volumes: Sequence[float]) -> Iterator[Fact]:
    """Yield the facts that depend on the volumes of objects. Object `i` has the volume ``volumes[i]``."""
    for i, mine in enumerate(volumes):
        if mine > MAX_GRASPABLE_VOLUME:
            yield Fact(p.ungraspable.name, (i,))
        for j, other in enumerate(volumes):
            if mine > other:
                yield Fact(p.larger.name, (i, j))
                if mine > MUCH_LARGER_RATIO * other:
                    yield Fact(p.much_larger.name, (i, j))


def compare_object_sizes_across_tasks(objects: Sequence[tuple[Task, int]]) -> Iterator[Fact]:
    """Yield the facts about sizes that hold if objects of several tasks are in one scene.

    Args:
        objects: for each object, its task and its index in the task's scene. Facts name an object by its
            position in this sequence.

    Raises:
        TypeError: a task is not a task of the data set.
    """
    evidence = load_unpublished_facts()
    records = [_get_record(task) for task, _ in objects]
    volumes = {record.id: estimate_object_volumes(record, evidence) for record in records}
    return _compare_volumes(
        [volumes[record.id][index] for record, (_, index) in zip(records, objects, strict=True)]
    )


def get_category_of_3d_model(task: Task, object_index: int) -> str:
    """Return the category of an object's 3D model, such as `coffee_table`. For a floor, it names the room.

    Raises:
        TypeError: the task is not a task of the data set.
    """
    objects = _get_record(task).objects
    if object_index >= len(objects):
        return task.scene.objects[object_index].category
    thing = objects[object_index]
    return thing.name.rstrip("0123456789") if thing.is_floor else thing.model


def _get_record(task: Task) -> BehaviorRecord:
    if not isinstance(task, BehaviorTask):
        raise TypeError(f"task {task.id} is not a task of BEHAVIOR")
    return task.record


class _BehaviorTaskBuilder:
    """Builds the scene, the initial state and the goals of one task."""

    def __init__(self, record: BehaviorRecord, unpublished_facts: UnpublishedSceneFacts) -> None:
        self._record = record
        self._evidence = unpublished_facts
        parts = (
            WorldObject(half, f"half_{obj.model}")
            for obj in record.objects
            for half in obj.names_of_sliced_halves
        )
        whole = (WorldObject(obj.name, obj.category) for obj in record.objects)
        self.scene = Scene(VOCABULARY, (*whole, *parts))
        self._index = self.scene.index

    def build_state(self, relations: Iterable[GroundRelation]) -> State:
        """Return the initial state of the task with the given relations."""
        return self.scene.state(
            (
                *self._yield_object_property_facts(),
                *_compare_volumes(estimate_object_volumes(self._record, self._evidence)),
                *self._yield_start_state_facts(relations),
            )
        )

    def yield_goals(self) -> Iterator[Goal]:
        """Yield the goals of the problem file, with object names of the scene."""
        problem = self._record.problem
        names = {obj.instance: obj.name for obj in self._record.objects}
        for formula in get_operands(rename_objects(problem.goal, names), And):
            yield Goal(_classify_goal(formula), formula)

    def yield_human_plan(self) -> Iterator[Action]:
        """Yield the actions of the plan that a human wrote. A misspelt action keeps its wrong name."""
        for action, objects in self._record.plan:
            yield Action(action, tuple([self._index[name] for name in objects]))

    def _yield_object_property_facts(self) -> Iterator[Fact]:
        for obj in self._record.objects:
            names = [_ABILITY_PREDICATES[a] for a in obj.abilities if a in _ABILITY_PREDICATES]
            names += [obj.model] if obj.model in _MODEL_CATEGORY_PREDICATES else []
            names += [p.floor.name] if obj.is_floor else []
            for object_name in (obj.name, *obj.names_of_sliced_halves):
                yield from (Fact(name, (self._index[object_name],)) for name in names)
            for half in obj.names_of_sliced_halves:
                yield Fact(p.part_of.name, (self._index[half], self._index[obj.name]))

    def _yield_start_state_facts(self, relations: Iterable[GroundRelation]) -> Iterator[Fact]:
        for state, name in yield_initial_states_of_objects(self._record, self._evidence):
            yield Fact(f"is_{state}", (self._index[name],))
        for predicate, source, target in relations:
            pair = (self._index[source], self._index[target])
            yield Fact(p.STORED[predicate].name, pair)
            if predicate == "nextto":
                yield Fact(p.STORED[predicate].name, pair[::-1])
        yield from self._yield_facts_placing_robot_on_floor()

    def _yield_facts_placing_robot_on_floor(self) -> Iterator[Fact]:
        floors = {obj.instance: obj.name for obj in self._record.objects if obj.is_floor}
        for fact in self._record.problem.initial:
            source, *target = (term.name for term in fact.arguments)
            if fact.predicate == "onfloor" and source.startswith("agent.") and target[0] in floors:
                yield Fact(p.robot_on.name, (self._index[floors[target[0]]],))


def _classify_goal(formula: Formula) -> GoalKind:
    """Return the kind of a goal: `RELATION` if the goal contains a relation, or else `STATE`."""
    return GoalKind.STATE if RELATIONS.isdisjoint(find_predicates(formula)) else GoalKind.RELATION
