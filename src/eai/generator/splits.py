"""Splits that share no goals: to which one a task belongs, and what two sets of tasks have in common."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import eai.logic.formula as f
from eai.abilities.goal_test import solves
from eai.abilities.task import Task
from eai.benchmark.lookup import LookupTable
from eai.generator import fingerprint
from eai.generator.prior import Pattern, patterns_of
from eai.generator.spec import HeldOut, Split
from eai.world.domain import Domain
from eai.world.state import Scene

SHARES = {Split.TRAIN: 0.6, Split.VALIDATION: 0.2, Split.TEST: 0.2}
"""The share of what is held out that falls to each split, in the order in which the splits are made."""

_ORDER = tuple(SHARES)


def split_of(key: str) -> Split:
    """The split that a hash gives a text."""
    return _split_at(_hash(key))


def _hash(key: str) -> float:
    return int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big") / 2**64


def _split_at(place: float) -> Split:
    """The split at a place between 0 and 1, of which each has its share."""
    for split, share in SHARES.items():
        place -= share
        if place < 0:
            return split
    return _ORDER[-1]


def split_of_goals(goals: Sequence[f.Formula], scene: Scene, held_out: HeldOut) -> Split:
    """The split to which a task with these goals belongs, whatever their objects are called."""
    if held_out is HeldOut.PAIRS:
        literals = [pattern for goal in goals for pattern in patterns_of(goal, scene)]
        splits = {split_of(f"pair {_pair(pattern, scene)}") for pattern in literals}
        if splits:
            return max(splits, key=_ORDER.index)
    return split_of(f"goals {fingerprint.of_goals(goals, scene)}")


def _pair(pattern: Pattern, scene: Scene) -> tuple[str, ...]:
    """The predicate, and the first kind of thing that is not the agent's."""
    agent = None if scene.agent is None else scene.objects[scene.agent].category
    return pattern.predicate, *[kind for kind in pattern.categories if kind != agent][:1]


def bases_of(tasks: Sequence[Task], split: Split, held_out: HeldOut) -> Sequence[Task]:
    """The public tasks from which those of a split are made.

    Titles and scenes are few, so that splits get their share of them, in the order of their hashes.
    """
    if split is Split.ALL or held_out not in (HeldOut.TITLES, HeldOut.SCENES):
        return tasks
    keys = [task.title if held_out is HeldOut.TITLES else task.id for task in tasks]
    ranked = sorted(set(keys), key=lambda key: _hash(f"{held_out.value} {key}"))
    splits = {key: _split_at((rank + 0.5) / len(ranked)) for rank, key in enumerate(ranked)}
    return [task for task, key in zip(tasks, keys, strict=True) if splits[key] is split]


class Rivals:
    """The tasks of other splits, whose plans are not to solve the tasks of this one, nor the other way round.

    Args:
        domain: whose world they are in.
        known: the tasks of earlier splits: no plan that `eai/lookup` finds among them solves a task.
        held_out: the tasks of later splits: none of them is solved by the plan of a task.
    """

    def __init__(self, domain: Domain, known: Iterable[Task] = (), held_out: Iterable[Task] = ()) -> None:
        self._domain = domain
        self._table = LookupTable(known, domain)
        self._held_out = tuple(held_out)

    def give_away(self, task: Task) -> bool:
        """Whether a task is solved by looking up another, or would be what another is solved by."""
        if solves(self._domain, task, self._table.plan(task)):
            return True
        own = LookupTable([task], self._domain)
        return any(solves(self._domain, each, own.plan(each)) for each in self._held_out)


@dataclass(frozen=True, slots=True)
class Overlap:
    """The overlap of tasks with others that are known, say those of a training set.

    Attributes:
        tasks: how many there are.
        same: those that are the same as a known one: equal goals of things that start alike.
        same_goals: those with the goals of a known one, objects known by kind.
        solved_by_lookup: those that are solved by the plan of the known task with the most similar goals.
    """

    tasks: int
    same: int
    same_goals: int
    solved_by_lookup: int

    @staticmethod
    def of(tasks: Iterable[Task], known: Sequence[Task], domain: Domain) -> Overlap:
        """Return the overlap of tasks with known ones."""
        asked = list(tasks)
        prints = {fingerprint.of_task(task) for task in known}
        goals = {each.goals for each in prints}
        table = LookupTable(known, domain)
        found = [fingerprint.of_task(task) for task in asked]
        return Overlap(
            len(asked),
            sum(each in prints for each in found),
            sum(each.goals in goals for each in found),
            sum(solves(domain, task, table.plan(task)) for task in asked),
        )


def is_before(one: str, other: str) -> bool:
    """Whether one name is that of a split, and the other that of a later one."""
    return one in _ORDER and other in _ORDER and _ORDER.index(Split(one)) < _ORDER.index(Split(other))
