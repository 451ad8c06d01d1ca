"""Compose scenes from several tasks of a data set: objects of other tasks, and places for objects.

An added object has its states, its parts and its place. Static relations, such as relative size, between
objects of different tasks are added only if the benchmark can compare these objects.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from itertools import permutations
from typing import TypeAlias

from eai.base.grouping import group_pairs
from eai.benchmarks.benchmark import CompareObjects, TaskObject
from eai.benchmarks.generator.measures import find_objects_of_goals_and_plan
from eai.benchmarks.generator.scene import (
    describe_place_by_relation_and_category,
    find_states_of_object,
    has_no_contents,
    list_in_random_order,
    make_free_name,
)
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet
from eai.tasks.task import Task
from eai.world.relation import iterate_bits
from eai.world.state import Fact, Scene, State, WorldObject

_MOVE_PROBABILITY = 0.5
"""Probability that a portable object gets the place that such an object has in another task."""

MentionedObjectsByCategory: TypeAlias = Mapping[str, "list[TaskObject]"]
"""Category -> objects of this category that published tasks mention."""


def list_mentioned_objects_by_category(tasks: Iterable[Task]) -> MentionedObjectsByCategory:
    """Return the objects that tasks mention, by category."""
    return group_pairs((task.scene.objects[i].category, (task, i)) for task in tasks for i in task.relevant)


def compose_scene_from_tasks(
    reduced_state: State,
    other_tasks: Iterable[Task],
    task_objects: MentionedObjectsByCategory,
    usual_goals: UsualGoalsOfDataSet,
    rng: random.Random,
    size: int,
    origins: MutableMapping[str, TaskObject] | None = None,
    model_of: Callable[[Task, int], str] | None = None,
    limits: Mapping[str, int] | None = None,
) -> State:
    """Return the scene with places and objects of other tasks, up to `size` objects.

    First, some portable objects of the scene move to a place that an object of their category has in another
    task. Then objects that other tasks need are added, if the scene has no object of their category. An added
    object keeps its states, its parts and its place. If the scene lacks its container or support, that is
    added, too.

    Args:
        reduced_state: the scene.
        other_tasks: tasks whose objects are added, in order, until the scene has `size` objects.
        task_objects: objects of other tasks, whose places are taken over.
        usual_goals: the usual goals, places of objects and actions.
        rng: the random generator.
        size: maximum number of objects.
        origins: name of an object -> the object of a task from which it was made. It gets an entry for each
            added object.
        model_of: returns the model of an object: the category of its 3D model, or the room of a floor. If it
            is given, `origins` has all objects of the scene. An object is a place like that in another scene
            only if it has the same model.
        limits: category -> maximum number of its objects. An object of a model that the scene lacks is added
            only below this maximum, or as the first object of its category.
    """
    scene = _SceneWithObjectsOfOtherTasks(
        reduced_state, usual_goals, rng, size, {} if origins is None else origins, model_of, limits or {}
    )
    for index, thing in enumerate(reduced_state.scene.objects):
        places = task_objects.get(thing.category)
        if places and scene.is_movable(index) and rng.random() < _MOVE_PROBABILITY:
            scene.move_object_like_other_scene(index, *rng.choice(places))
    for task in other_tasks:
        for index in list_in_random_order(sorted(find_objects_of_goals_and_plan(task)), rng):
            scene.find_or_add_counterpart_of_object(task, index)
    return scene.make_state()


def add_static_facts_comparing_objects(
    state: State, origin_by_object_name: Mapping[str, TaskObject], compare_objects: CompareObjects
) -> State:
    """Return the state with the static facts that compare its objects, such as relations of size.

    The objects may come from different tasks, whose states do not compare them.

    Args:
        state: the state.
        origin_by_object_name: name of each object of the state -> the task's object from which it was made.
        compare_objects: returns these facts for objects of tasks.
    """
    scene = state.scene
    facts = compare_objects([origin_by_object_name[thing.name] for thing in scene.objects])
    return Scene(scene.vocabulary, scene.objects, scene.agent).state(dict.fromkeys([*state.facts(), *facts]))


class _SceneWithObjectsOfOtherTasks:
    """A scene to which objects of other tasks are added.

    Args:
        reduced_state: the scene before the objects are added.
        usual_goals: the usual goals, places of objects and actions.
        rng: the random generator.
        size: maximum number of objects.
        origins: name of an object -> the object of a task from which it was made. Added objects get an entry.
        model_of: returns the category of an object's 3D model, or the room of a floor. None to compare
            objects by their categories.
        limits: category -> maximum number of its objects. An object of a model that the scene lacks is added
            only below this maximum, or as the first object of its category.
    """

    def __init__(
        self,
        reduced_state: State,
        usual_goals: UsualGoalsOfDataSet,
        rng: random.Random,
        size: int,
        origins: MutableMapping[str, TaskObject],
        model_of: Callable[[Task, int], str] | None,
        limits: Mapping[str, int],
    ) -> None:
        self._reduced_state, self._prior, self._rng, self._size = reduced_state, usual_goals, rng, size
        self._origins, self._model_of, self._limits = origins, model_of, limits
        self._objects, self._facts = list(reduced_state.scene.objects), dict.fromkeys(reduced_state.facts())
        self._held = {
            fact.arguments[-1]
            for fact in self._facts
            if fact.predicate in usual_goals.holding_predicate_names
        }
        self._excluded = set(usual_goals.part_categories)

    def is_movable(self, index: int) -> bool:
        """Whether an object is portable and empty, has a place, and is not held."""
        reduced_state, usual_goals = self._reduced_state, self._prior
        return (
            reduced_state.scene.objects[index].category in usual_goals.taken_categories
            and index not in self._held
            and has_no_contents(index, reduced_state, usual_goals)
            and bool(describe_place_by_relation_and_category(index, reduced_state, usual_goals))
        )

    def move_object_like_other_scene(self, index: int, other_task: Task, other_object: int) -> None:
        """Give an object of this scene the place that an object has in another scene.

        Nothing changes if this scene has no such place.

        Args:
            index: the object of this scene.
            other_task: the task of the other scene.
            other_object: the object of the other scene.
        """
        places = self._find_corresponding_place_in_this_scene(other_task, other_object)
        if places and all(target != index for _, target in places):
            static = {p.name for p in self._reduced_state.scene.vocabulary.predicates if p.static}
            self._facts = {
                fact: None
                for fact in self._facts
                if index not in fact.arguments or len(fact.arguments) < 2 or fact.predicate in static
            }
            self._facts |= {Fact(name, (index, target)): None for name, target in places}

    def find_or_add_counterpart_of_object(
        self, other_task: Task, other_object: int, counterparts: Mapping[int, int] | None = None
    ) -> int | None:
        """Return the index of an object of this scene that corresponds to an object of another scene.

        Both have the same category. If this scene has no such object, one is added. Return None if all such
        objects differ in place from the other object, or if none can be added.

        Args:
            other_task: the task of the other scene.
            other_object: index of the object in the other scene.
            counterparts: objects of the other scene -> corresponding objects of this scene. If the mapping is
                given, the result must have the model of `other_object`. A place relation between
                `other_object` and a key must also hold between the result and the key's value. None if any
                object of the category will do.
        """
        other_state = other_task.initial
        thing = other_state.scene.objects[other_object]
        alike = [i for i, other in enumerate(self._objects) if other.category == thing.category]
        fitting = alike
        if counterparts is not None and self._model_of is not None:
            model = self._model_of(other_task, other_object)
            fitting = [i for i in alike if self._model_of(*self._origins[self._objects[i].name]) == model]
        if fitting:
            related = [
                i
                for i in fitting
                if self._has_equal_places(other_state, {**(counterparts or {}), other_object: i})
            ]
            return self._rng.choice(related) if related else None
        if thing.category in self._excluded or other_object == other_state.scene.agent:
            return None
        if alike and len(alike) >= self._limits.get(thing.category, 0):
            return None
        self._excluded.add(thing.category)  # such objects may be in each other
        places = self._find_corresponding_place_in_this_scene(other_task, other_object)
        self._excluded.remove(thing.category)
        parts = list(self._yield_part_relations_and_parts_of_object(other_state, other_object))
        if places is None or len(self._objects) + len(parts) >= self._size:
            return None
        index = self._add_object(other_task, other_object, make_free_name(thing.name, self._objects))
        self._facts |= dict.fromkeys(Fact(name, (index, target)) for name, target in places)
        for name, part in parts:
            part_name = other_state.scene.objects[part].name
            if part_name.startswith(thing.name):
                part_name = self._objects[index].name + part_name.removeprefix(thing.name)
            if any(part_name == other.name for other in self._objects):
                part_name = make_free_name(part_name, self._objects)
            self._facts[Fact(name, (self._add_object(other_task, part, part_name), index))] = None
        return index

    def _yield_part_relations_and_parts_of_object(
        self, state: State, whole_object: int
    ) -> Iterator[tuple[str, int]]:
        """Yield, for each part of an object, a pair: the relation of the part to the object, and the part."""
        for name in self._prior.part_relations:
            yield from ((name, part) for part in iterate_bits(state.relation(name).column(whole_object)))

    def _add_object(self, other_task: Task, other_object: int, name: str) -> int:
        """Add an object with its states. Return its index."""
        index = len(self._objects)
        self._objects.append(WorldObject(name, other_task.scene.objects[other_object].category))
        self._origins[name] = other_task, other_object
        states = find_states_of_object(other_object, other_task.initial)
        self._facts |= dict.fromkeys(
            Fact(state, (index,)) for state in states if state not in self._prior.unique_states
        )
        return index

    def _find_corresponding_place_in_this_scene(
        self, other_task: Task, other_object: int
    ) -> list[tuple[str, int]] | None:
        """Return the place in this scene that corresponds to the place of an object in another scene.

        A place is a list of pairs: a relation, and the object to which it relates. Return None if such an
        object can neither be found in this scene nor added.
        """
        other_state = other_task.initial
        rows = [
            (name, target)
            for name in self._prior.place_relations
            for target in iterate_bits(other_state.relation(name).row(other_object))
            if not other_state.has(name, target, other_object)
        ]
        counterparts: dict[int, int] = {}
        for target in dict.fromkeys(target for _, target in rows):
            found = (
                None
                if target == other_state.scene.agent
                else self.find_or_add_counterpart_of_object(other_task, target, counterparts)
            )
            if found is None:
                return None
            counterparts[target] = found
        return [(name, counterparts[target]) for name, target in rows]

    def _has_equal_places(self, other_state: State, counterparts: Mapping[int, int]) -> bool:
        """Whether each object has the same place as its counterpart in the other scene."""
        return all(
            Fact(name, (counterparts[one], counterparts[other])) in self._facts
            for name in self._prior.place_relations
            for one, other in permutations(counterparts, 2)
            if other_state.has(name, one, other)
        )

    def make_state(self) -> State:
        """Return the scene as a state."""
        reduced_state = self._reduced_state.scene
        return Scene(reduced_state.vocabulary, self._objects, reduced_state.agent).state(self._facts)
