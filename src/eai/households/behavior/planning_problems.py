"""BEHAVIOR's own planning problems, in PDDL: parts of activities, with other spellings of their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import eai.logic.formula as f
from eai.households.behavior.activities import Activities
from eai.households.behavior.convert import AGENT_CATEGORY
from eai.logic.renaming import rename_objects
from eai.pddl.model import PddlDomain, PddlProblem, TypedName
from eai.tasks.problem_world import Posed, header_of

_DOMAIN = "igibson"
_AGENT = "agent"
_DEFINITION = "_0"
"""Which definition of an activity such a problem is a part of, as the names of definitions end."""
_SAME = "same_obj"
"""What holds of every object and itself; no state tells it."""


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
