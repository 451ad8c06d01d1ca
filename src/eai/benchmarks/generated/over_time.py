"""Goals over time: what must come first, and what must never be, read off two plans for the same goals.

One plan is the certificate, the other a *temptation*: it reaches all goals about the end as well, in another
order, or without a detour. What holds on the way of the one and not of the other is asked for: so it can be
kept, and it matters.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.task import GoalKind, Task
from eai.benchmarks.generated.goals import Proposals
from eai.benchmarks.generated.prior import Prior
from eai.benchmarks.generated.walk import Walk, certificate
from eai.logic.semantics import holds
from eai.logic.traversal import objects
from eai.planning.planner import Planner
from eai.world.domain import Domain
from eai.world.execution import Action, execute
from eai.world.listing import Listing
from eai.world.state import Fact, State
from eai.world.timeline import timeline

_Goals: TypeAlias = Sequence[f.Formula]
_Begin: TypeAlias = Callable[[], Walk]

_ORDERS = 3
"""In how many orders the goals are reached to find a temptation."""


@dataclass(frozen=True)
class OverTime:
    """A goal over time, a plan that keeps it, and one that reaches all else but does not."""

    goal: f.Formula
    plan: Sequence[Action]
    temptation: Sequence[Action]


@dataclass(frozen=True)
class Seeker:
    """Looks for goals over time.

    Attributes:
        domain: in which plans are executed.
        walked: the same, as far as it is usual; in it plans are found.
        prior: what is usual.
        listings: what goals can say.
    """

    domain: Domain
    walked: Domain
    prior: Prior
    listings: Sequence[Listing]

    def find(
        self, task: Task, start: State, planner: Planner, proposals: Proposals, rng: random.Random
    ) -> OverTime | None:
        """A goal over time for a task with a certificate, or None if none is found.

        Args:
            task: the task.
            start: its initial state, as it is walked in.
            planner: finds other plans.
            proposals: what may be seen on a detour.
            rng: chooses.
        """
        goals = [goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION]
        if len(goals) < len(task.goals):
            return None
        ways = [self._after_a_detour, self._tidily, self._in_order]
        for way in rng.sample(ways, len(ways)):
            found = way(task, goals, lambda: Walk(self.walked, planner, start), proposals, rng)
            if found is not None:
                return found
        return None

    def _after_a_detour(
        self, task: Task, goals: _Goals, begin: _Begin, proposals: Proposals, rng: random.Random
    ) -> OverTime | None:
        """Something that is to be so before a goal is reached, and not in the end."""
        walk, seen, last = begin(), proposals.literal(rng), rng.choice(goals)
        start = walk.state
        if seen is None or not isinstance(last, f.Atom | f.Not) or not walk.reach(seen):
            return None
        walk.conditions.clear()
        if not _reach_all(walk, goals) or walk.holds(seen, walk.state):
            return None
        goal = f.Then((seen, last))
        return self._if_it_matters(task, goal, certificate(walk, start, goal), task.script)

    def _tidily(
        self, task: Task, goals: _Goals, begin: _Begin, proposals: Proposals, rng: random.Random
    ) -> OverTime | None:
        """What the certificate leaves as nobody asks for it (open, switched on) must not be while ..."""
        changing = self._changing(task, task.script)
        left = [
            atom
            for atom in changing
            if len(atom.arguments) == 1 and atom not in goals and begin().holds(atom, self._final(task))
        ]
        if not left:
            return None
        never, walk = rng.choice(left), begin()
        start = walk.state
        for wanted in goals:
            if not walk.holds(wanted, walk.state) and not walk.reach(wanted):
                return None
            if walk.holds(never, walk.state):
                walk.reach(f.Not(never))
                walk.conditions = [each for each in walk.conditions if each != f.Not(never)]
        if not all(walk.holds(each, walk.state) for each in goals):
            return None
        for other in rng.sample(changing, len(changing)):
            if other != never:
                goal = f.Always(f.Not(f.And((never, other))))
                kept = self._if_it_matters(task, goal, walk.trail, task.script)
                if kept is not None:
                    return replace(kept, plan=certificate(walk, start, goal))
        return None

    def _final(self, task: Task) -> State:
        return execute(self.domain, task.initial, task.script).final

    def _in_order(
        self, task: Task, goals: _Goals, begin: _Begin, proposals: Proposals, rng: random.Random
    ) -> OverTime | None:
        """What comes first on the way of the certificate, and not where the goals are reached otherwise."""
        for _ in range(_ORDERS if len(goals) > 1 else 0):
            walk = begin()
            start = walk.state
            if _reach_all(walk, rng.sample(goals, len(goals))):
                found = self._between(task, certificate(walk, start), rng)
                if found is not None:
                    return found
        return None

    def _between(self, task: Task, other: Sequence[Action], rng: random.Random) -> OverTime | None:
        """What holds on the way of the certificate, and not of another plan; rather about one thing."""
        candidates = list(self._candidates(task, task.script, other))
        rng.shuffle(candidates)
        candidates.sort(key=lambda goal: not _is_of_one_thing(goal))
        kept = (self._if_it_matters(task, goal, task.script, other) for goal in candidates)
        return next((found for found in kept if found is not None), None)

    def _candidates(self, task: Task, plan: Sequence[Action], other: Sequence[Action]) -> Iterator[f.Formula]:
        changing = self._changing(task, plan)
        tempting = dict.fromkeys(self._changing(task, other))
        both = [atom for atom in changing if atom in tempting]
        for first, then in permutations(both, 2):
            yield f.Until(f.Not(then), first)
        for first, second in permutations(both, 2):
            if objects(first) < objects(second):
                yield f.Always(f.Not(f.And((first, second))))
        wanted = {name for alternatives in self.prior.actions for name in alternatives}
        for action in plan:
            if action.operator in wanted and action.arguments:
                names = [f.Constant(task.scene.objects[i].name) for i in action.arguments]
                yield from (f.Until(f.Not(then), f.Occurs(action.operator, tuple(names))) for then in both)

    def _changing(self, task: Task, plan: Sequence[Action]) -> list[f.Atom]:
        """What a plan makes so that was not so at the start, as far as goals say it of things."""
        things, agent = task.scene.objects, task.scene.agent
        usual = [each for each in self.listings if (each.predicate, True) in self.prior.wanted]
        states = execute(self.domain, task.initial, plan).states
        found: dict[f.Atom, None] = {}
        for each in usual:
            at_start = set(each.facts(states[0], task.relevant))
            for fact in (fact for state in states[1:] for fact in each.facts(state, task.relevant)):
                if fact not in at_start and agent not in fact.arguments and self._moves(fact, task):
                    terms = [f.Constant(things[i].name) for i in fact.arguments]
                    found[f.Atom(fact.predicate, tuple(terms))] = None
        return list(found)

    def _moves(self, fact: Fact, task: Task) -> bool:
        """Whether a fact is the state of a thing, or the place of one that is ever taken in hand."""
        moved = task.scene.objects[fact.arguments[0]].category
        return len(fact.arguments) == 1 or not self.prior.kinds or moved in self.prior.taken

    def _if_it_matters(
        self, task: Task, goal: f.Formula, plan: Sequence[Action], other: Sequence[Action]
    ) -> OverTime | None:
        """The goal, if it holds on the way of the one plan and not of the other."""
        ways = [timeline(execute(self.domain, task.initial, each)) for each in (plan, other)]
        kept, tempted = [holds(goal, way) for way in ways]
        return OverTime(goal, plan, other) if kept and not tempted else None


def _reach_all(walk: Walk, goals: Sequence[f.Formula]) -> bool:
    """Reach goals in an order, and tell whether all hold in the end."""
    for goal in goals:
        if walk.holds(goal, walk.state):
            walk.conditions.append(goal)
        elif not walk.reach(goal):
            return False
    return all(walk.holds(goal, walk.state) for goal in goals)


def _is_of_one_thing(goal: f.Formula) -> bool:
    """Whether the two things that are said share an object."""
    match goal:
        case f.Until(f.Not(then), first) | f.Always(f.Not(f.And((then, first)))):
            return not set(objects(then)).isdisjoint(objects(first))
        case _:
            return False
