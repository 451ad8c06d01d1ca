"""Closed scenes: a few objects of a task's scene, of which what is shown is all there is."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from eai.abilities.task import Task
from eai.benchmarks.generated.prior import Prior
from eai.world.relation import bits
from eai.world.state import Fact, Scene, State

LEAST_OBJECTS = 16
"""How many objects a scene has at least, where the task's own has so many."""


class Closed(NamedTuple):
    """A scene and what holds in it."""

    scene: Scene
    facts: tuple[Fact, ...]


def closed_scene(task: Task, prior: Prior, rng: random.Random, most: int) -> Closed:
    """Some of a task's objects: those that it is about, and others that plans and goals know.

    What stands somewhere comes with the place, and a part with its whole. Of a relation in which things stand
    to many others only what concerns the agent is kept; of two things that are said to be in each other,
    neither is.
    """
    state = task.initial
    everything = range(len(state.scene.objects))
    size = rng.randint(min(LEAST_OBJECTS, most), most)
    chosen: set[int] = set() if state.scene.agent is None else _with_places(state.scene.agent, state, prior)
    usual = prior.taken | prior.used
    others = [i for i in everything if not usual or state.scene.objects[i].category in usual]
    for index in (*_shuffled(task.relevant, rng), *_by_category(others, state.scene, rng)):
        if len(chosen) >= size:
            break
        wider = chosen | _with_places(index, state, prior)
        if len(wider) <= most:
            chosen = wider
    kept = sorted(chosen)
    scene = Scene(
        state.scene.vocabulary,
        [state.scene.objects[i] for i in kept],
        None if state.scene.agent is None else kept.index(state.scene.agent),
    )
    return Closed(scene, tuple(_facts_among(state, kept, prior)))


def _shuffled(indices: Sequence[int], rng: random.Random) -> list[int]:
    return rng.sample(indices, len(indices))


def _by_category(indices: Sequence[int], scene: Scene, rng: random.Random) -> Iterator[int]:
    """Objects in random order, one of each category before the second of any."""
    ranked: dict[str, int] = {}
    order = []
    for index in _shuffled(indices, rng):
        category = scene.objects[index].category
        ranked[category] = ranked.get(category, -1) + 1
        order.append((ranked[category], rng.random(), index))
    return (index for _, _, index in sorted(order))


def _with_places(index: int, state: State, prior: Prior) -> set[int]:
    """An object with all that it stands in or on, and with the parts and the wholes of these."""
    found, pending = set(), [index]
    while pending:
        current = pending.pop()
        if current in found:
            continue
        found.add(current)
        for name in prior.places:
            pending += bits(state.relation(name).row(current))
        for name in prior.parts:
            pending += bits(state.relation(name).row(current) | state.relation(name).column(current))
    return found


def _facts_among(state: State, kept: Sequence[int], prior: Prior) -> Iterator[Fact]:
    """The facts about some objects alone, numbered anew."""
    number = {index: i for i, index in enumerate(kept)}
    agent = state.scene.agent
    static = {predicate.name for predicate in state.scene.vocabulary.predicates if predicate.static}
    for predicate, arguments in restricted(state, kept):
        if len(arguments) == 2 and predicate not in static:
            if predicate not in prior.places and agent not in arguments:
                continue
            if predicate in prior.places and state.has(predicate, *reversed(arguments)):
                continue
        yield Fact(predicate, tuple([number[i] for i in arguments]))


def restricted(state: State, kept: Sequence[int]) -> Iterator[Fact]:
    """The facts of a state about some objects alone, first by predicate."""
    vocabulary, among = state.scene.vocabulary, sum([1 << i for i in kept])
    for name in vocabulary.unary_slots:
        if not vocabulary.arity(name):
            yield from [Fact(name, ())] if state.those(name) else ()
            continue
        yield from (Fact(name, (i,)) for i in bits(state.those(name) & among))
    for name in vocabulary.binary_slots:
        relation = state.relation(name)
        yield from (Fact(name, (i, j)) for i in kept for j in bits(relation.row(i) & among))
