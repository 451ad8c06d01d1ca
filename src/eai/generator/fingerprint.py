"""Fingerprints: what stays of a task when its objects are known by category alone."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.logic.ltl_printer import print_ltl
from eai.logic.rewriting import rename_objects, rename_variables
from eai.logic.traversal import objects, walk
from eai.world.relation import bits
from eai.world.state import Scene, State


class Prints(NamedTuple):
    """The digests that distinguish tasks: of its goals, and of its scene."""

    goals: str
    scene: str


def of_goals(goals: Iterable[f.Formula], scene: Scene) -> str:
    """The fingerprint of goals: equal if they ask for the same of objects of the same categories."""
    categories = _categories(scene)
    texts = [print_ltl(rename_variables(rename_objects(goal, categories))) for goal in goals]
    return _digest(sorted(texts))


def of_scene(initial: State, goals: Iterable[f.Formula]) -> str:
    """The fingerprint of what can change and holds at the start of what the goals speak of."""
    scene, vocabulary = initial.scene, initial.scene.vocabulary
    named = {index for goal in goals for index in spoken_of(goal, scene)}
    static = {predicate.name for predicate in vocabulary.predicates if predicate.static}
    facts = [
        f"{fact.predicate} {[scene.objects[i].category for i in fact.arguments]}"
        for fact in initial.facts()
        if fact.predicate not in static and named.intersection(fact.arguments)
    ]
    return _digest(sorted(facts))


def of(goals: Sequence[f.Formula], initial: State) -> Prints:
    """The fingerprints of goals, and of the scene in which they are to be reached."""
    return Prints(of_goals(goals, initial.scene), of_scene(initial, goals))


def of_task(task: Task) -> Prints:
    """Both fingerprints of a task."""
    return of([goal.formula for goal in task.goals], task.initial)


def spoken_of(goal: f.Formula, scene: Scene) -> Iterator[int]:
    """The objects that a goal names or ranges over."""
    yield from (scene.index[name] for name in objects(goal))
    for part in walk(goal):
        match part:
            case f.ForAll(variable) | f.Exists(variable) | f.Exactly(variable=variable):
                yield from bits(scene.category(variable.category))
            case f.ForPairs(first, second):
                yield from bits(scene.category(first.category) | scene.category(second.category))


def _categories(scene: Scene) -> Mapping[str, str]:
    return {thing.name: thing.category for thing in scene.objects}


def _digest(texts: Iterable[str]) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]
