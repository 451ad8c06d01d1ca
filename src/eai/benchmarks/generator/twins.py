"""Pairs of tasks: of one there is no plan, or of one the words fit two things.

A task without a plan: one fact is taken away from it so that it has none, and another so that it keeps one.
That there is no plan is proved by the delete relaxation (`eai.planning.possible`). Both twins lack one fact
that says what a thing is good for, of the same predicate, and goals speak of both things in the same way:
neither that a thing lacks something, nor what it lacks, says whether there is a plan. Nor does the kind of
thing: it is the same in both twins, or it has been on either side about as often in the pairs before.

An ambiguous instruction: in both tasks one thing is wanted, told by its place. In the ambiguous task a second
one of its kind stands there too. Whoever does with the second what is asked of the first fails, also beside
the first: so one who never asks is right about as often as by chance.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.reports import fact_text
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.measures import presence
from eai.benchmarks.generator.prior import Prior
from eai.benchmarks.generator.scene import is_empty, shuffled, stance, with_double
from eai.benchmarks.generator.spec import Generated
from eai.benchmarks.generator.words import Words
from eai.logic.rewriting import rename_objects
from eai.logic.traversal import bound_variables, object_names, walk
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.goal_test import solves
from eai.tasks.planning import find_plan, is_impossible
from eai.tasks.special import Ambiguous, Impossible
from eai.tasks.task import Goal, Task, goal
from eai.tasks.wording import is_property
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Fact, State

_HALF = 0.5
"""How often the thing that comes in besides is the wanted one."""

_LIMITS = Limits(300)
"""The limits of the search for a plan by which the other thing is had."""

Leaning: TypeAlias = Counter[tuple[str, str]]
"""How many more tasks without a plan than with one were for want of a property, of a thing of a kind."""


def twins_of(
    made: Generated, planner: Planner, may_lack: Collection[str], leaning: Leaning, rng: random.Random
) -> Generated | None:
    """A pair of twins; None if none is found.

    Args:
        made: a task with a plan.
        planner: for the domain; where goals look reachable to it no proof is tried.
        may_lack: the properties that a thing may lack; all if empty.
        leaning: of the pairs before; the new one is counted, too.
        rng: chooses.
    """
    task, domain = made.task, planner.domain
    there, holds = presence(domain), planner.heuristic.readings.holds
    known = _properties(task, domain, may_lack)
    facts = [fact for fact in known if holds(there, {"x": fact.arguments[0]}, task.initial)]
    rng.shuffle(facts)
    needed = [fact for fact in facts if not solves(domain, _without(task, fact), task.script)]
    others = [fact for fact in facts if fact not in needed]
    sorts = {fact: _sort(fact, task) for fact in facts}
    for fact in needed:
        kind = _kind(fact, task)
        alike = [other for other in others if sorts[other] == sorts[fact]]
        same = [other for other in alike if _kind(other, task) == kind]
        even = same or [other for other in alike if leaning[kind] <= 0 <= leaning[_kind(other, task)]]
        lacking = _without(task, fact)
        if even and not _looks_possible(lacking, planner) and is_impossible(lacking, domain):
            other = rng.choice(even)
            leaning[kind] += 1
            leaning[_kind(other, task)] -= 1
            return _paired(made, fact, other, rng)
    return None


def _looks_possible(task: Task, planner: Planner) -> bool:
    """Whether each goal looks as if it could be reached."""
    goals = (each.formula for each in task.goals)
    return all(planner.looks_reachable(task.initial, each, task.planned_with) for each in goals)


def _properties(task: Task, domain: Domain, may_lack: Collection[str]) -> Iterator[Fact]:
    """The facts that say what things are good for, as prompts tell them."""
    shown = {p.name for p in domain.vocabulary.predicates if p.visible and is_property(p)}
    for fact in task.initial.facts():
        if fact.predicate in shown and (not may_lack or fact.predicate in may_lack):
            yield fact


def _sort(fact: Fact, task: Task) -> tuple[str, bool, bool]:
    """The property, and whether goals name what has it, or speak of all or some of its kind."""
    (thing,) = fact.arguments
    parts = (part for each in task.goals for part in walk(each.formula))
    kinds = {variable.category for part in parts for variable in bound_variables(part)}
    return fact.predicate, thing in task.named_by(task.goals), _kind(fact, task)[1] in kinds


def _kind(fact: Fact, task: Task) -> tuple[str, str]:
    """The property, and the category of what has it."""
    return fact.predicate, task.scene.objects[fact.arguments[0]].category


def _without(task: Task, fact: Fact) -> Task:
    """A task that begins without a fact."""
    return replace(task, initial=task.scene.state(each for each in task.initial.facts() if each != fact))


def _ids_of(task: Task, rng: random.Random) -> list[str]:
    """The ids of the twins of a task, in an order by chance."""
    return rng.sample([f"{task.id}-a", f"{task.id}-b"], 2)


def _paired(made: Generated, fact: Fact, other: Fact, rng: random.Random) -> Generated:
    """The twins."""
    task, scene, names = made.task, made.task.scene, _ids_of(made.task, rng)
    solved = replace(_without(task, other), id=names[0], title=task.id, special=Impossible(()))
    missing = Impossible((fact_text(fact, scene),))
    unsolved = replace(_without(task, fact), id=names[1], title=task.id, script=(), special=missing)
    lacks: Mapping[str, Json] = {**made.about, "lacks": fact_text(other, scene)}
    return Generated(solved, lacks, Generated(unsolved, made.about))


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
                pair = _in_same_words(task, words, (apart, beside), thing, rng)
                if pair is not None and _is_open(*pair, thing, planner):
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


def _in_same_words(
    task: Task, words: Words, states: tuple[State, State], thing: int, rng: random.Random
) -> tuple[Task, Task] | None:
    """The clear and the ambiguous task, by their initial states; None if words say other goals."""
    ids, formulas = _ids_of(task, rng), [each.formula for each in task.goals]
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
    )
    unclear = replace(clear, id=ids[1], initial=unclear_initial)
    if rng.random() < _HALF:
        clear, unclear, names = _exchanged(clear, names), _exchanged(unclear, names), names[::-1]
    return replace(clear, special=Ambiguous(names[:1])), replace(unclear, special=Ambiguous(names))


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
    )


def _only(goals: Sequence[Goal], names: Sequence[str]) -> Goal:
    """That what is asked of the first thing is not done with the second."""
    asked = [each for each in goals if names[0] in object_names(each.formula)]
    done = tuple([each.formula for each in _renamed(asked, names)])
    return goal(f.Not(done[0] if len(done) == 1 else f.And(done)))


def _renamed(goals: Iterable[Goal], names: Sequence[str]) -> tuple[Goal, ...]:
    """Goals about the second thing in place of the first, and the other way round."""
    return tuple([goal(rename_objects(each.formula, _swapped(names))) for each in goals])


def _swapped(names: Sequence[str]) -> Mapping[str, str]:
    return dict(zip(names, reversed(names), strict=True))


def _is_open(clear: Task, unclear: Task, thing: int, planner: Planner) -> bool:
    """Whether the plan solves both tasks, and each of the things can be had in the ambiguous one."""
    names = [unclear.scene.objects[i].name for i in (thing, -1)]
    other = replace(unclear, goals=_renamed(unclear.goals, names))
    each_solves = (solves(planner.domain, task, task.script) for task in (clear, unclear))
    return all(each_solves) and bool(find_plan(other, planner, _LIMITS).plan)
