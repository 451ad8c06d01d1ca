"""Ambiguous instructions: pairs of tasks in the same words, which fit two things in one, one in the other.

In both one thing is wanted, told by its place. In the ambiguous task a second one of its kind stands there
too. Whoever does with the second what is asked of the first fails, also beside the first: so one who never
asks is right about as often as by chance.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import eai.logic.formula as f
from eai.abilities.goal_test import solves
from eai.abilities.planning import find_plan
from eai.abilities.task import Goal, Task, goal
from eai.benchmark.benchmark import Benchmark
from eai.generator.prior import Prior
from eai.generator.scene import is_empty, shuffled, stance, with_double
from eai.generator.spec import Generated
from eai.generator.twins import ids_of
from eai.generator.words import Words
from eai.logic.rewriting import rename_objects
from eai.logic.traversal import objects
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.world.execution import Action
from eai.world.state import Fact, State

_HALF = 0.5
"""How often the thing that comes in besides is the wanted one."""

_LIMITS = Limits(300)
"""The limits of the search for a plan by which the other thing is had."""


def ambiguous(
    made: Generated, benchmark: Benchmark, prior: Prior, planner: Planner, rng: random.Random
) -> Generated | None:
    """A pair of twins; None if none is found.

    Args:
        made: a task with a plan.
        benchmark: whose world it is in.
        prior: says where things stand.
        planner: for its domain.
        rng: chooses.
    """
    task, kinds = made.task, [thing.category for thing in made.task.scene.objects]
    hosts = [i for i in task.relevant if kinds[i] in prior.taken and stance(i, task.initial, prior)]
    named = task.named_by(task.goals)
    for thing in shuffled([i for i in hosts if i in named and is_empty(i, task.initial, prior)], rng):
        beside = with_double(task.initial, prior, thing, thing)
        seen = Words.of(benchmark, beside, by_place=True).seen
        for host in shuffled(hosts, rng):
            apart = with_double(task.initial, prior, thing, host)
            words = Words.of(benchmark, apart, by_place=True)
            if _fits_both(words, seen, thing):
                pair = _paired(task, words, (apart, beside), thing, rng)
                if pair is not None and _is_open(*pair, planner):
                    return Generated(pair[0], made.about, Generated(pair[1], made.about))
                break
    return None


def _fits_both(words: Words, seen: Iterable[Fact], thing: int) -> bool:
    """Whether what tells a thing from its double by its place fits both, where these facts are seen."""
    said = words.apart.get(thing)
    if said is None or len(said.arguments) == 1:
        return False
    place = said.arguments[1:]
    there = {each[1][0] for each in seen if (each[0], each[1][1:]) == (said.predicate, place)}
    return {thing, len(words.scene.objects) - 1} <= there


def _paired(
    task: Task, words: Words, states: tuple[State, State], thing: int, rng: random.Random
) -> tuple[Task, Task] | None:
    """The clear and the ambiguous task, by their initial states; None if words say other goals."""
    ids, formulas = ids_of(task, rng), [each.formula for each in task.goals]
    instruction = words.instruction(formulas, rng)
    if not words.says(instruction, formulas):
        return None
    initial, unclear_initial = states
    names = (task.scene.objects[thing].name, initial.scene.objects[-1].name)
    clear = replace(
        task,
        id=ids[0],
        title=task.id,
        instruction=instruction,
        initial=initial,
        goals=(*task.goals, _only(task.goals, names)),
        relevant=(*task.relevant, len(task.scene.objects)),
        fits=names[:1],
    )
    unclear = replace(clear, id=ids[1], initial=unclear_initial, fits=names)
    if rng.random() < _HALF:
        clear, unclear = _exchanged(clear, names), _exchanged(unclear, names)
    return clear, unclear


def _exchanged(task: Task, names: Sequence[str]) -> Task:
    """A task in which one of two things has the part of the other, so that no name tells which is wanted."""
    scene, swapped = task.scene, _swapped(names)
    index = {scene.index[name]: scene.index[other] for name, other in swapped.items()}

    def of(arguments: Sequence[int]) -> tuple[int, ...]:
        return tuple([index.get(i, i) for i in arguments])

    return replace(
        task,
        initial=scene.state(Fact(each.predicate, of(each.arguments)) for each in task.initial.facts()),
        goals=_renamed(task.goals, names),
        script=tuple([Action(step.operator, of(step.arguments)) for step in task.script]),
        fits=tuple([swapped[name] for name in task.fits or ()]),
    )


def _only(goals: Sequence[Goal], names: Sequence[str]) -> Goal:
    """That what is asked of the first thing is not done with the second."""
    asked = [each for each in goals if names[0] in objects(each.formula)]
    done = tuple([each.formula for each in _renamed(asked, names)])
    return goal(f.Not(done[0] if len(done) == 1 else f.And(done)))


def _renamed(goals: Iterable[Goal], names: Sequence[str]) -> tuple[Goal, ...]:
    """Goals about the second thing in place of the first, and the other way round."""
    return tuple([goal(rename_objects(each.formula, _swapped(names))) for each in goals])


def _swapped(names: Sequence[str]) -> Mapping[str, str]:
    return dict(zip(names, reversed(names), strict=True))


def _is_open(clear: Task, unclear: Task, planner: Planner) -> bool:
    """Whether the plan solves both tasks, and each of the things can be had in the ambiguous one."""
    other = replace(unclear, goals=_renamed(unclear.goals, unclear.fits or ()))
    each_solves = (solves(planner.domain, task, task.script) for task in (clear, unclear))
    return all(each_solves) and bool(find_plan(other, planner, _LIMITS).plan)
