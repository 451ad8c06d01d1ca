"""Pairs: a task from which one fact is taken away so that it has no plan, and another so that it keeps one.

That there is no plan is proved by the delete relaxation (`eai.planning.possible`). Both twins lack one fact
that says what a thing is good for, of the same predicate, and goals speak of both things in the same way:
neither that a thing lacks something, nor what it lacks, says whether there is a plan. Nor does the kind of
thing: it is the same in both twins, or it has been on either side about as often in the pairs before.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import TypeAlias

from eai.abilities.goal_test import solves
from eai.abilities.planning import is_impossible
from eai.abilities.reports import fact_text
from eai.abilities.task import Task
from eai.abilities.verdict import Json
from eai.abilities.wording import is_property
from eai.generator.measures import presence
from eai.generator.spec import Generated
from eai.logic.traversal import bound_by, walk
from eai.planning.planner import Planner
from eai.world.domain import Domain
from eai.world.state import Fact

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
    kinds = {variable.category for part in parts for variable in bound_by(part)}
    return fact.predicate, thing in task.named_by(task.goals), _kind(fact, task)[1] in kinds


def _kind(fact: Fact, task: Task) -> tuple[str, str]:
    """The property, and the category of what has it."""
    return fact.predicate, task.scene.objects[fact.arguments[0]].category


def _without(task: Task, fact: Fact) -> Task:
    """A task that begins without a fact."""
    return replace(task, initial=task.scene.state(each for each in task.initial.facts() if each != fact))


def ids_of(task: Task, rng: random.Random) -> list[str]:
    """The ids of the twins of a task, in an order by chance."""
    return rng.sample([f"{task.id}-a", f"{task.id}-b"], 2)


def _paired(made: Generated, fact: Fact, other: Fact, rng: random.Random) -> Generated:
    """The twins."""
    task, scene, names = made.task, made.task.scene, ids_of(made.task, rng)
    solved = replace(_without(task, other), id=names[0], title=task.id, missing=())
    missing = fact_text(fact, scene)
    unsolved = replace(_without(task, fact), id=names[1], title=task.id, script=(), missing=(missing,))
    lacks: Mapping[str, Json] = {**made.about, "lacks": fact_text(other, scene)}
    return Generated(solved, lacks, Generated(unsolved, made.about))
