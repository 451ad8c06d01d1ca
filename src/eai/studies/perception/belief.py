"""Make the task that a planner faces if it knows only a perceived scene.

The perceived scene graph replaces the facts that a scene graph can list. All other facts, such as properties
of objects, come from the true scene. An object that the graph does not name belongs to no category of the
domain, and no action may name it. An invented name becomes an object with the properties of the first object
with a similar name.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.logic.traversal import find_object_names
from eai.studies.perception.scene_graph import (
    SceneGraph,
    SceneGraphFact,
    SceneGraphVocabulary,
    SupportRelation,
)
from eai.tasks.task import Task
from eai.tasks.wording import list_objects_in_prompt
from eai.world.state import Fact, Scene, State, WorldObject

UNSEEN = "(unseen)"
"""Category of an object that the scene graph does not name."""

_STEM = re.compile(r"[\W_]*\d*$")


def make_scene_graph_vocabulary(benchmark: Benchmark) -> SceneGraphVocabulary:
    """Return the names of predicates and objects in scene graphs; prompts for plans use the same names."""
    return SceneGraphVocabulary(benchmark.wording(Ability.ACTION_SEQUENCING))


def replace_scenes_of_benchmark(benchmark: Benchmark, graphs: Mapping[str, SceneGraph]) -> Benchmark:
    """Return the benchmark with scene graphs in place of the scenes of its tasks.

    ``graphs`` maps task ids to scene graphs. Goals about an object that the graph lacks are left out, because
    no plan can reach them.
    """
    words = make_scene_graph_vocabulary(benchmark)

    def replace_scene_by_perceived_scene(task: Task) -> Task:
        graph = graphs.get(task.id)
        if graph is None:
            return task
        seen = replace_scene_by_scene_graph(task, words, graph)
        unseen = {item.name for item in seen.scene.objects if item.category == UNSEEN}
        goals = [goal for goal in seen.goals if unseen.isdisjoint(find_object_names(goal.formula))]
        return replace(seen, goals=tuple(goals))

    return benchmark.with_changed_tasks(replace_scene_by_perceived_scene)


def replace_scene_by_scene_graph(task: Task, words: SceneGraphVocabulary, graph: SceneGraph) -> Task:
    """Return the task with the scene that a scene graph describes."""
    true_graph = words.make_true_graph(task)
    if set(graph.facts) == set(true_graph.facts) and set(graph.mentioned_objects) == set(true_graph.objects):
        return task
    perceived_scene = _PerceivedScene(task, words, graph)
    return replace(
        task,
        initial=perceived_scene.make_perceived_state(true_graph),
        relevant=perceived_scene.list_relevant_object_indices(),
    )


class _PerceivedScene:
    """A task's scene as a scene graph describes it: its state and its objects."""

    def __init__(self, task: Task, words: SceneGraphVocabulary, graph: SceneGraph) -> None:
        self._task = task
        self._words = words
        self._graph = graph
        names = words.list_object_names(task)
        self._index = {name: index for index, name in enumerate(names)}
        self._invented = {
            name: self._find_index_of_similarly_named_object(name)
            for name in graph.mentioned_objects
            if name not in self._index
        }
        self._index |= {name: len(names) + number for number, name in enumerate(self._invented)}
        agent = task.scene.agent
        self._unseen = {i for i in task.relevant if names[i] not in graph.mentioned_objects and i != agent}

    def list_relevant_object_indices(self) -> tuple[int, ...]:
        seen = [index for index in self._task.relevant if index not in self._unseen]
        return (*seen, *range(len(self._task.scene.objects), len(self._index)))

    def make_perceived_state(self, true_graph: SceneGraph) -> State:
        index, seen = self._index, set(self._graph.facts)
        undescribed = set(self._task.initial.facts()) - {
            self._convert_to_fact_of_state(fact) for fact in true_graph.facts
        }
        kept = [fact for fact in self._task.initial.facts() if fact in undescribed]
        first = [fact for fact in true_graph.facts if fact in seen]
        further = [fact for fact in self._graph.facts if fact not in set(first)]
        perceived = [
            self._convert_to_fact_of_state(fact)
            for fact in self._select_jointly_possible_facts([*first, *further], set(true_graph.facts))
        ]
        static = {item.name for item in self._task.scene.vocabulary.predicates if item.static}
        copied = [
            Fact(fact.predicate, (index[name],))
            for name, model in self._invented.items()
            for fact in kept
            if model is not None and fact.arguments == (model,) and fact.predicate in static
        ]
        return self._make_scene().state([*kept, *perceived, *copied])

    def _select_jointly_possible_facts(
        self, facts: Sequence[SceneGraphFact], true_facts: set[SceneGraphFact]
    ) -> Iterator[SceneGraphFact]:
        """Yield the facts of a list that can all be true in one state.

        A fact is left out if it would make an object support itself, even through other objects, or give an
        object a second support.
        """
        words = self._words
        forms = {item.name for item in self._task.scene.vocabulary.predicates if item.single}
        single = {
            words.find_predicate_name_in_graphs(name)
            for name, form in words.stored_forms.items()
            if form in forms
        }
        supports = SupportRelation(
            frozenset(words.find_predicate_name_in_graphs(name) for name in words.placement_predicate_names)
        )
        for fact in facts:
            if words.predicate_by_name_in_graphs[fact.predicate] not in words.stored_forms:
                continue
            if (
                fact not in true_facts
                and fact.predicate in single
                and supports.would_add_second_support(fact)
            ):
                continue
            if not supports.would_close_cycle(fact):
                supports.add_fact(fact)
                yield fact

    def _convert_to_fact_of_state(self, fact: SceneGraphFact) -> Fact:
        form = self._words.stored_forms[self._words.predicate_by_name_in_graphs[fact.predicate]]
        return Fact(form, tuple([self._index[name] for name in fact.arguments]))

    def _make_scene(self) -> Scene:
        """Return the objects of the scene.

        Unperceived objects have the category `UNSEEN`; invented objects come last.
        """
        scene = self._task.scene
        objects = [
            WorldObject(item.name, UNSEEN) if index in self._unseen else item
            for index, item in enumerate(scene.objects)
        ]
        for name, model in self._invented.items():
            objects.append(
                WorldObject(name, _STEM.sub("", name) if model is None else scene.objects[model].category)
            )
        return Scene(scene.vocabulary, objects, scene.agent)

    def _find_index_of_similarly_named_object(self, name: str) -> int | None:
        """Return the first object of the prompt with a name that differs at most in its number, or None."""
        stem = _STEM.sub("", name)
        names = self._words.list_object_names(self._task)
        return next((i for i in list_objects_in_prompt(self._task) if _STEM.sub("", names[i]) == stem), None)
