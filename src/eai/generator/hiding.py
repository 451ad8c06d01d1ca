"""Things put out of sight before a task begins, so that whoever solves it has to open something."""

from __future__ import annotations

from itertools import chain
from typing import NamedTuple

import eai.logic.formula as f
from eai.abilities.task import Task
from eai.generator.measures import lids
from eai.generator.prior import Pattern, Prior, Theme
from eai.logic.traversal import walk
from eai.planning.effect_schema import effect_schemas
from eai.planning.planner import Planner, PlanningEnd, PlanningGoal, PlanningLimits
from eai.world.derived import stored_sources
from eai.world.domain import Domain
from eai.world.execution import execute
from eai.world.state import State

_LIMITS = PlanningLimits(100, thorough=False)
"""What may be spent on putting a thing somewhere."""


class Place(NamedTuple):
    """Where something may be put out of sight: a relation to a thing that can be shut, by category."""

    relation: str
    thing: str
    container: str


class Hiding:
    """Puts things where tasks put them, into what plans open, and shuts it.

    Args:
        domain: whose world it is.
        prior: what is usual in it.
    """

    def __init__(self, domain: Domain, prior: Prior) -> None:
        self._domain, self._prior = domain, prior
        self._lids = sorted(set(lids(domain)))
        said = [] if domain.visible is None else [p for p in walk(domain.visible) if isinstance(p, f.Atom)]
        told = stored_sources([part.predicate for part in said], domain.vocabulary)
        names = {lid.predicate for lid in self._lids}
        opening = {
            operator.name
            for operator in domain.operators
            if any(schema.atom.predicate in names for schema in effect_schemas(operator))
        }
        opened = {kind.category for kind in prior.kinds if kind.operator in opening}
        usual = chain(*(known for theme in prior.themes.values() for known in theme.patterns.values()))
        self._places = [
            Place(pattern.predicate, *pattern.categories)
            for pattern in dict.fromkeys(usual)
            if pattern.truth and len(pattern.categories) == 2 and pattern.predicate in told
            if pattern.categories[0] in prior.taken and pattern.categories[1] in opened
        ]

    def places(self, task: Task) -> list[Place]:
        """Where things could be in the scene of a task of which its title wants something else."""
        here = {thing.category for thing in task.scene.objects}
        theme = self._prior.themes[task.title]
        return [
            place
            for place in self._places
            if {place.thing, place.container} <= here and self._is_wanted_elsewhere(place, theme)
        ]

    def _is_wanted_elsewhere(self, place: Place, theme: Theme) -> bool:
        """Whether a title wants something of a kind of thing besides that it be in a place."""
        wanted = [
            p for patterns in theme.patterns.values() for p in patterns if p.categories[:1] == (place.thing,)
        ]
        usual = [p for p in wanted if p.truth and self._prior.used.issuperset(p.categories[1:])]
        told = (*usual, *chain(*theme.endings))
        there = Pattern(place.relation, (place.thing, place.container), truth=True)
        return any(place.thing in pattern.categories for pattern in told if pattern != there)

    def hide(self, planner: Planner, state: State, relation: str, thing: str, container: str) -> State | None:
        """A state with a thing out of sight, by actions however unusual; None if no way is found."""
        index = state.scene.index
        objects = [
            index[thing],
            index[container],
            *([] if state.scene.agent is None else [state.scene.agent]),
        ]
        put = f.Atom(relation, (f.Constant(thing), f.Constant(container)))
        lids = [f.Atom(lid.predicate, (f.Constant(container),)) for lid in self._lids]
        shut = [f.Not(shown) if lid.reveals else shown for lid, shown in zip(self._lids, lids, strict=True)]
        asked = PlanningGoal(())
        for wanted in (put, *shut):
            asked = PlanningGoal((*asked.conditions, wanted))
            found = planner.plan(state, asked, objects, _LIMITS)
            if found.end is not PlanningEnd.SOLVED:
                return None
            state = execute(self._domain, state, found.plan).final
        return state
