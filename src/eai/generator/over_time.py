"""Goals over time: what must come first, and what must never be, read off two plans for the same goals.

One plan is the certificate, the other a *temptation*: it reaches all goals about the end as well, in another
order, or without a detour. What holds on the way of the one and not of the other is asked for: so it can be
kept, and it matters.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, permutations
from operator import itemgetter
from typing import TypeAlias

import eai.logic.formula as f
from eai.abilities.task import GoalKind, Task
from eai.generator.goals import Proposals
from eai.generator.prior import Prior
from eai.generator.walk import Walk, certificate
from eai.logic.semantics import holds
from eai.logic.trace import Trace
from eai.logic.traversal import objects
from eai.planning.planner import Planner
from eai.world.domain import Domain
from eai.world.execution import Action, Trajectory, execute
from eai.world.listing import Listing
from eai.world.state import Fact, State
from eai.world.timeline import timeline

_Goals: TypeAlias = Sequence[f.Formula]
_Begin: TypeAlias = Callable[[], Walk]

_SHUFFLES = 6
"""In how many orders parts of the certificate are tried to find a temptation."""

_TIDY = 3
"""After how many parts of the certificate to tidy up is tried."""


@dataclass(frozen=True)
class _OverTime:
    """A goal over time, a plan that keeps it, and one that reaches all else but does not."""

    goal: f.Formula
    plan: Sequence[Action]
    temptation: Sequence[Action]


@dataclass(frozen=True)
class _Course:
    """A plan, and what it leads through.

    Attributes:
        plan: the plan.
        trajectory: what it leads through.
        became: what it makes so that was not so at the start, with the numbers of the states in which it is.
    """

    plan: Sequence[Action]
    trajectory: Trajectory
    became: Mapping[f.Atom, Sequence[int]]

    @cached_property
    def timeline(self) -> Trace:
        return timeline(self.trajectory)

    def comes_first(self, first: f.Atom, then: f.Atom) -> bool:
        """Whether one thing is not so before another is."""
        return self.became[first][0] <= self.became[then][0]

    def has_both(self, one: f.Atom, other: f.Atom) -> bool:
        """Whether two things are ever so at once."""
        return not set(self.became[one]).isdisjoint(self.became[other])


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
    ) -> _OverTime | None:
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
    ) -> _OverTime | None:
        """Something that is to be so before a goal is reached, and not in the end."""
        walk, seen, last = begin(), proposals.literal(rng), rng.choice(goals)
        if seen is None or not isinstance(last, f.Atom | f.Not) or not walk.reach(seen):
            return None
        walk.conditions.clear()
        if not (walk.follow(task.script, goals) or _reach_all(walk, goals)) or walk.holds(seen, walk.state):
            return None
        goal = f.Then((seen, last))
        detour, direct = self._course(task, walk.trail), self._course(task, task.script)
        kept = _if_it_matters(goal, detour, direct)
        return None if kept is None else replace(kept, plan=certificate(walk, goal))

    def _tidily(
        self, task: Task, goals: _Goals, begin: _Begin, proposals: Proposals, rng: random.Random
    ) -> _OverTime | None:
        """What the certificate leaves as nobody asks for it (open, switched on) must not be while ..."""
        untidy = self._course(task, task.script)
        last = len(untidy.plan)
        left = [
            atom
            for atom, when in untidy.became.items()
            if len(atom.arguments) == 1 and atom not in goals and when[-1] == last
        ]
        if not left:
            return None
        never = rng.choice(left)
        cuts = [cut for cut in self._cuts(goals, untidy) if cut >= untidy.became[never][0]]
        for cut in cuts[:_TIDY]:
            walk = begin()
            if (
                walk.follow(untidy.plan[:cut], ())
                and walk.reach(f.Not(never))
                and walk.follow(untidy.plan[cut:], goals)
            ):
                tidy = self._course(task, walk.trail)
                for other in rng.sample(list(untidy.became), len(untidy.became)):
                    goal = f.Always(f.Not(f.And((never, other))))
                    kept = _if_it_matters(goal, tidy, untidy) if other != never else None
                    if kept is not None:
                        walk.conditions = list(goals)
                        return replace(kept, plan=certificate(walk, goal))
        return None

    def _course(self, task: Task, plan: Sequence[Action]) -> _Course:
        trajectory = execute(self.domain, task.initial, plan)
        return _Course(plan, trajectory, self._became(task, trajectory.states))

    def _in_order(
        self, task: Task, goals: _Goals, begin: _Begin, proposals: Proposals, rng: random.Random
    ) -> _OverTime | None:
        """What comes first on the way of the certificate, and not where the same is done in another order."""
        ours = self._course(task, task.script)
        cuts = self._cuts(goals, ours)
        parts = [ours.plan[i:j] for i, j in zip([0, *cuts], cuts, strict=False)]
        for _ in range(_SHUFFLES if len(parts) > 1 else 0):
            found = self._between(task, goals, ours, list(chain(*rng.sample(parts, len(parts)))), rng)
            if found is not None:
                return found
        walk = begin()
        if len(goals) > 1 and _reach_all(walk, rng.sample(goals, len(goals))):
            return self._between(task, goals, ours, certificate(walk), rng)
        return None

    def _cuts(self, goals: _Goals, course: _Course) -> list[int]:
        """After how many steps of a plan one goal more holds to the end."""
        states = list(enumerate(course.trajectory.states))[::-1]
        missed = (next(i for i, state in states if not self.domain.holds(goal, state)) for goal in goals)
        return sorted({i + 1 for i in missed})

    def _between(
        self, task: Task, goals: _Goals, ours: _Course, plan: Sequence[Action], rng: random.Random
    ) -> _OverTime | None:
        """What holds on our way, and not on that of another plan, if it is one; rather about one thing."""
        trajectory = execute(self.domain, task.initial, plan)
        if trajectory.failure is not None or not all(
            self.domain.holds(goal, trajectory.final) for goal in goals
        ):
            return None
        other = _Course(plan, trajectory, self._became(task, trajectory.states))
        candidates = list(self._candidates(task, ours, other))
        rng.shuffle(candidates)
        candidates.sort(key=itemgetter(0))
        kept = (_if_it_matters(goal, ours, other) for _, goal in candidates)
        return next((found for found in kept if found is not None), None)

    def _candidates(self, task: Task, ours: _Course, other: _Course) -> Iterator[tuple[bool, f.Formula]]:
        """Goals that may tell one way from another, and whether what they name has no object in common."""
        both = [atom for atom in ours.became if atom in other.became]
        for first, then in permutations(both, 2):
            if ours.comes_first(first, then) and not other.comes_first(first, then):
                yield _are_apart(then, first), f.Until(f.Not(then), first)
            if objects(first) < objects(then) and other.has_both(first, then) > ours.has_both(first, then):
                yield _are_apart(first, then), f.Always(f.Not(f.And((first, then))))
        wanted = {name for alternatives in self.prior.actions for name in alternatives}
        for action in ours.plan:
            if action.operator in wanted and action.arguments:
                names = [f.Constant(task.scene.objects[i].name) for i in action.arguments]
                done = f.Occurs(action.operator, tuple(names))
                yield from ((_are_apart(then, done), f.Until(f.Not(then), done)) for then in both)

    def _became(self, task: Task, states: Sequence[State]) -> Mapping[f.Atom, Sequence[int]]:
        """What came to be so in which states, as far as goals say it of things."""
        things, agent = task.scene.objects, task.scene.agent
        found: dict[Fact, list[int]] = {}
        for each in self.listings:
            if (each.predicate, True) in self.prior.wanted:
                at_start = set(each.facts(states[0], task.relevant))
                for number, state in enumerate(states):
                    for fact in each.facts(state, task.relevant):
                        if fact not in at_start:
                            found.setdefault(fact, []).append(number)
        return {
            f.Atom(fact.predicate, tuple([f.Constant(things[i].name) for i in fact.arguments])): when
            for fact, when in found.items()
            if agent not in fact.arguments and self._moves(fact, task)
        }

    def _moves(self, fact: Fact, task: Task) -> bool:
        """Whether a fact is the state of a thing, or the place of one that is ever taken in hand."""
        moved = task.scene.objects[fact.arguments[0]].category
        return len(fact.arguments) == 1 or not self.prior.kinds or moved in self.prior.taken


def _if_it_matters(goal: f.Formula, ours: _Course, other: _Course) -> _OverTime | None:
    """The goal, if it holds on our way and not on the other."""
    kept, tempted = [holds(goal, course.timeline) for course in (ours, other)]
    return _OverTime(goal, ours.plan, other.plan) if kept and not tempted else None


def _reach_all(walk: Walk, goals: Sequence[f.Formula]) -> bool:
    """Reach goals in an order, and tell whether all hold in the end."""
    for goal in goals:
        if walk.holds(goal, walk.state):
            walk.conditions.append(goal)
        elif not walk.reach(goal):
            return False
    return all(walk.holds(goal, walk.state) for goal in goals)


def _are_apart(one: f.Formula, other: f.Formula) -> bool:
    """Whether two things that are said have no object in common."""
    return set(objects(one)).isdisjoint(objects(other))
