"""Tasks as someone believes them to be who has only perceived their scene.

What is described of a scene is as it was perceived; all else, such as what objects are good for, is as it is.
An object that is not perceived is not there for whoever plans: no action may name it, and it is of no kind. A
name that the scene has not is an object like the first one whose name begins alike.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from eai.abilities.protocol import Ability
from eai.benchmarks.benchmark import Benchmark
from eai.logic.traversal import object_names
from eai.studies.perception.scene_graph import NamedFact, SceneGraph, SceneWords, Supports
from eai.tasks.task import Task
from eai.tasks.wording import prompt_objects
from eai.world.state import Fact, Scene, State, WorldObject

UNSEEN = "(unseen)"
"""The category of an object that is not perceived."""

_STEM = re.compile(r"[\W_]*\d*$")


def scene_words(benchmark: Benchmark) -> SceneWords:
    """How scene graphs of a benchmark say what is so: as prompts of action sequencing do."""
    return SceneWords(benchmark.wording(Ability.ACTION_SEQUENCING))


def perceiving(benchmark: Benchmark, graphs: Mapping[str, SceneGraph]) -> Benchmark:
    """The benchmark as one plans in it who sees the scenes of scene graphs, by task id.

    Goals that name what is not seen are passed over: nothing can be done about it.
    """
    words = scene_words(benchmark)

    def believed(task: Task) -> Task:
        graph = graphs.get(task.id)
        if graph is None:
            return task
        seen = believed_task(task, words, graph)
        unseen = {thing.name for thing in seen.scene.objects if thing.category == UNSEEN}
        goals = [each for each in seen.goals if unseen.isdisjoint(object_names(each.formula))]
        return replace(seen, goals=tuple(goals))

    return benchmark.with_changed(believed)


def believed_task(task: Task, words: SceneWords, graph: SceneGraph) -> Task:
    """The task with the scene that a graph shows."""
    described = words.describe(task)
    if set(graph.facts) == set(described.facts) and set(graph.names) == set(described.objects):
        return task
    believer = _Believer(task, words, graph)
    return replace(task, initial=believer.state(described), relevant=believer.relevant())


class _Believer:
    """A task as one scene graph shows it."""

    def __init__(self, task: Task, words: SceneWords, graph: SceneGraph) -> None:
        self._task = task
        self._words = words
        self._graph = graph
        names = words.names(task)
        self._index = {name: index for index, name in enumerate(names)}
        self._strangers = {name: self._model(name) for name in graph.names if name not in self._index}
        self._index |= {name: len(names) + place for place, name in enumerate(self._strangers)}
        agent = task.scene.agent
        self._unseen = {i for i in task.relevant if names[i] not in graph.names and i != agent}

    def relevant(self) -> tuple[int, ...]:
        """The objects that an answer may name: those that are seen, be they there or not."""
        seen = [index for index in self._task.relevant if index not in self._unseen]
        return (*seen, *range(len(self._task.scene.objects), len(self._index)))

    def state(self, described: SceneGraph) -> State:
        """The perceived state."""
        index, seen = self._index, set(self._graph.facts)
        undescribed = set(self._task.initial.facts()) - {self._stored(fact) for fact in described.facts}
        kept = [fact for fact in self._task.initial.facts() if fact in undescribed]
        first = [fact for fact in described.facts if fact in seen]
        further = [fact for fact in self._graph.facts if fact not in set(first)]
        perceived = [self._stored(fact) for fact in self._possible([*first, *further], set(described.facts))]
        static = {each.name for each in self._task.scene.vocabulary.predicates if each.static}
        copied = [
            Fact(fact.predicate, (index[name],))
            for name, model in self._strangers.items()
            for fact in kept
            if model is not None and fact.arguments == (model,) and fact.predicate in static
        ]
        return self._scene().state([*kept, *perceived, *copied])

    def _possible(self, facts: Sequence[NamedFact], described: set[NamedFact]) -> Iterator[NamedFact]:
        """The facts that a state can hold: those with a stored form, without circles or second supports."""
        words = self._words
        forms = {each.name for each in self._task.scene.vocabulary.predicates if each.single}
        single = {words.spelling(name) for name, form in words.stored.items() if form in forms}
        supports = Supports(frozenset(words.spelling(name) for name in words.supports))
        for fact in facts:
            if words.predicates[fact.predicate] not in words.stored:
                continue
            if fact not in described and fact.predicate in single and supports.rests(fact):
                continue
            if not supports.closes(fact):
                supports.add(fact)
                yield fact

    def _stored(self, fact: NamedFact) -> Fact:
        form = self._words.stored[self._words.predicates[fact.predicate]]
        return Fact(form, tuple([self._index[name] for name in fact.arguments]))

    def _scene(self) -> Scene:
        """The objects: what is not seen is of no kind, what is seen without being there comes last."""
        scene = self._task.scene
        things = [
            WorldObject(thing.name, UNSEEN) if index in self._unseen else thing
            for index, thing in enumerate(scene.objects)
        ]
        for name, model in self._strangers.items():
            things.append(
                WorldObject(name, _STEM.sub("", name) if model is None else scene.objects[model].category)
            )
        return Scene(scene.vocabulary, things, scene.agent)

    def _model(self, name: str) -> int | None:
        """The first object that a prompt speaks of whose name begins like this one."""
        stem = _STEM.sub("", name)
        names = self._words.names(self._task)
        return next((i for i in prompt_objects(self._task) if _STEM.sub("", names[i]) == stem), None)
