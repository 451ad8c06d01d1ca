"""BEHAVIOR's own planning problems, in PDDL: parts of activities, with other spellings of their names.

The objects of a problem are those of its goals, those of the categories that bring such goals about, and all
that an initial condition about one of them names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.households.behavior.activities import Activities
from eai.households.behavior.convert import AGENT_CATEGORY
from eai.households.behavior.records import BehaviorRecord
from eai.households.behavior.tasks import BehaviorTask
from eai.logic.renaming import rename_objects
from eai.logic.traversal import walk
from eai.pddl.model import PddlDomain, PddlProblem, TypedName
from eai.pddl.writer import write_problem
from eai.tasks.problem_world import Posed, header_of

AGENT = "agent.n.01"
_CLEANERS = (
    "vacuum.n.04",
    "scrub_brush.n.01",
    "piece_of_cloth.n.01",
    "towel.n.01",
    "rag.n.01",
    "dishwasher.n.01",
    "dishtowel.n.01",
    "hand_towel.n.01",
)
HELPERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "dusty": _CLEANERS,
        "stained": (*_CLEANERS, "sink.n.01"),
        "soaked": ("teapot.n.01", "sink.n.01"),
        "sliced": ("carving_knife.n.01", "countertop.n.01", "knife.n.01"),
        "frozen": ("electric_refrigerator.n.01",),
        "cooked": ("pan.n.01",),
    }
)
"""Predicate of a goal -> the categories of what may bring it about (``pddl_generator.py``)."""


_DOMAIN = "igibson"

_AGENT = "agent"

_DEFINITION = "_0"
"""Which definition of an activity such a problem is a part of, as the names of definitions end."""

_SAME = "same_obj"
"""What holds of every object and itself; no state tells it."""


def problem_text(task: Task, goals: Sequence[f.Formula]) -> str:
    """The problem of reaching some ground conditions of a task."""
    if not isinstance(task, BehaviorTask):
        raise TypeError(f"{task.id} is no task of BEHAVIOR")
    instances = {each.name: each.instance for each in task.record.objects}
    return write_problem(problem_of(task.record, [rename_objects(goal, instances) for goal in goals]))


def problem_of(record: BehaviorRecord, goals: Sequence[f.Formula]) -> PddlProblem:
    """The problem of reaching some ground conditions about the instances of a problem file."""
    problem = record.problem
    categories = {each.name: each.category for each in problem.objects}
    named = {name for goal in goals for name in _named(goal)}
    predicates = {atom.predicate for goal in goals for atom in _atoms(goal)}
    helping = {category for name in predicates for category in HELPERS.get(name, ())}
    named |= {name for name, category in categories.items() if category in helping}
    about_objects = [each for each in problem.init if categories.keys() >= set(_named(each))]  # not rooms
    kept = [each for each in about_objects if named.intersection(_named(each))]
    named |= {name for each in kept for name in _named(each)}
    things = sorted(named)
    facts = [each for each in kept if isinstance(each, f.Atom)]
    facts += [f.Atom("same_obj", (f.Constant(name), f.Constant(name))) for name in things]
    pddl = {name: name.replace(".", "_") for name in categories}
    declared = [
        TypedName(pddl[name], _type_of(categories[name])) for name in categories if _is_there(name, named)
    ]
    return PddlProblem(
        name=record.activity,
        domain=problem.domain,
        objects=tuple(declared),
        initial=tuple(_in_pddl(fact, pddl) for fact in facts),
        denied=tuple(_in_pddl(each.operand, pddl) for each in kept if isinstance(each, f.Not)),
        goal=f.And(tuple(rename_objects(goal, pddl) for goal in goals)),
    )


def _is_there(name: str, named: set[str]) -> bool:
    return name in named or name.startswith(AGENT)


def _type_of(category: str) -> str:
    return "agent" if category == AGENT else category.replace(".", "_")


def _in_pddl(fact: f.Formula, names: Mapping[str, str]) -> f.Atom:
    found = rename_objects(fact, names)
    if not isinstance(found, f.Atom):
        raise TypeError(f"{fact} is no atom")
    return found


def _atoms(formula: f.Formula) -> Iterator[f.Atom]:
    return (part for part in walk(formula) if isinstance(part, f.Atom))


def _named(formula: f.Formula) -> Iterator[str]:
    return (term.name for atom in _atoms(formula) for term in atom.arguments)


@dataclass(frozen=True)
class PlanningProblems:
    """How planning problems of the data set are read, whose names have underscores instead of dots.

    Attributes:
        activities: how they are read with the names of activities.
    """

    activities: Activities

    @property
    def header(self) -> PddlDomain:
        """The types and predicates that problems may name."""
        arities = {each.name: len(each.parameters) for each in self.activities.header.predicates}
        return header_of(_DOMAIN, (*self._categories, _AGENT), {}, {**arities, _SAME: 2})

    @property
    def _categories(self) -> Mapping[str, str]:
        """Categories by spelling."""
        return {each.name.replace(".", "_"): each.name for each in self.activities.header.types}

    def pose(self, problem: PddlProblem) -> Posed:
        """A problem of these names."""
        categories = {**self._categories, _AGENT: AGENT_CATEGORY}
        things = [_spelt_out(each, categories[each.type]) for each in problem.objects]
        names = {each.name: thing.name for each, thing in zip(problem.objects, things, strict=True)}
        told = [rename_objects(each, names) for each in problem.initial if each.predicate != _SAME]
        initial = tuple([each for each in told if isinstance(each, f.Atom)])
        goal = rename_objects(problem.goal, names)
        posed = self.activities.pose(
            replace(
                problem,
                name=f"{problem.name}{_DEFINITION}",
                objects=tuple(things),
                initial=initial,
                goal=goal,
            )
        )
        return Posed(posed.initial, lambda formula: posed.meaning(_meaning(formula, names)))


def _spelt_out(thing: TypedName, category: str) -> TypedName:
    """An object as activities name it: ``basket.n.01_1`` for ``basket_n_01_1``."""
    spelling = category.replace(".", "_")
    known = thing.name.startswith(f"{spelling}_")
    return TypedName(f"{category}{thing.name.removeprefix(spelling)}" if known else thing.name, category)


def _meaning(formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
    match formula:
        case f.Atom(name, (one, other)) if name == _SAME:
            return f.TRUE if one == other else rename_objects(f.Equals(one, other), names)
        case _:
            return rename_objects(formula, names)
