"""A walk through a scene that reaches one goal after the other, the certificate, and goals over time.

A goal over time, what must come first or never be, is read off two plans for the same goals. One is the
certificate, the other a *temptation*: it reaches all goals about the end as well, in another order, or
without a detour. What holds on the way of the one and not of the other is asked for: it can be kept, and it
matters.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise, permutations
from operator import itemgetter

import eai.logic.formula as f
import eai.logic.semantics as semantics
from eai.benchmarks.generator.goals import Proposals
from eai.logic.trace import Trace
from eai.logic.traversal import object_names
from eai.planning.planner import Planner, PlanningGoal, drop_needless_actions
from eai.planning.search import Limits, Node, SearchEnd
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, execute, to_trace
from eai.world.listing import FactListing
from eai.world.state import Fact, State

_FOR_A_GOAL = Limits(20, thorough=False)
"""The limits of the search for reaching one goal more."""

_FOR_ALL = Limits(300)
"""The limits of the search for finding a shorter plan for all goals than the walk was."""

_LONG = 25
"""From how many steps on that is tried."""

_SHUFFLES = 6
"""In how many orders parts of the certificate are tried to find a temptation."""

_TIDY = 3
"""After how many parts of the certificate to tidy up is tried."""


@dataclass
class Walk:
    """A way from goal to goal.

    Attributes:
        planner: finds the way, by actions that are usual.
        state: where the walk is.
        start: where it began.
        conditions: the goals about states that hold here and are to last.
        actions: the action goals, in the order in which they were met.
        goals: all of them, in the order in which they were reached.
        trail: all actions so far.
    """

    planner: Planner
    state: State
    start: State = field(init=False)
    conditions: list[f.Formula] = field(default_factory=list)
    actions: list[tuple[str, ...]] = field(default_factory=list)
    goals: list[f.Formula] = field(default_factory=list)
    trail: list[Action] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.start = self.state

    @property
    def objects(self) -> tuple[int, ...]:
        """The objects of actions: all there are."""
        return tuple(range(len(self.state.scene.objects)))

    def mark(self) -> tuple[State, int, int, int, int]:
        """Where the walk is, to come back to."""
        return self.state, len(self.conditions), len(self.actions), len(self.goals), len(self.trail)

    def back_to(self, mark: tuple[State, int, int, int, int]) -> None:
        """Forget all that came after a mark."""
        self.state, conditions, actions, goals, trail = mark
        del self.conditions[conditions:], self.actions[actions:], self.goals[goals:], self.trail[trail:]

    def holds(self, wanted: f.Formula, state: State) -> bool:
        """Whether a goal about states is met; one about actions never is."""
        return not _actions_of(wanted) and self.planner.holds(wanted, state)

    def reach(self, wanted: f.Formula) -> bool:
        """Walk until one goal more is met, if a way is found."""
        names = _actions_of(wanted)
        if names:
            asked = PlanningGoal(tuple(self.conditions), (names,))
        elif self.holds(wanted, self.state):
            return False
        else:
            asked = PlanningGoal((*self.conditions, wanted))
        found = self.planner.plan(self.state, asked, self.objects, _FOR_A_GOAL)
        if found.end is not SearchEnd.SOLVED:
            return False
        for action in found.plan:
            self.state = self.planner.domain.apply(self.state, action)
        self.trail += found.plan
        self.goals.append(wanted)
        if names:
            self.actions.append(names)
        else:
            self.conditions.append(wanted)
        return True

    def follow(self, plan: Sequence[Action], goals: Sequence[f.Formula]) -> bool:
        """Walk by a plan, if that leads to some goals about states."""
        course = execute(self.planner.domain, self.state, plan)
        if course.failure is not None or not all(self.holds(goal, course.final) for goal in goals):
            return False
        self.state = course.final
        self.trail += plan
        self.goals += goals
        self.conditions += goals
        return True


def _actions_of(wanted: f.Formula) -> tuple[str, ...]:
    """The actions one of which a goal asks for; none if it is about states."""
    parts = f.operands(wanted, f.Or)
    return tuple([part.action for part in parts if isinstance(part, f.Occurs)])


def certificate(walk: Walk, over_time: f.Formula | None = None) -> Sequence[Action]:
    """The walk without needless steps, or a shorter plan that the planner finds for all goals.

    The planner is asked where the walk was long; a short one it follows step by step. It knows nothing of
    goals over time.
    """
    asked = PlanningGoal(tuple(walk.conditions), tuple(walk.actions))
    walked = _without_needless(walk, asked, over_time)
    if len(walked) < _LONG or over_time is not None:
        return walked
    found = walk.planner.plan(walk.start, asked, walk.objects, _FOR_ALL).plan
    return found if 0 < len(found) < len(walked) else walked


def _without_needless(walk: Walk, asked: PlanningGoal, over_time: f.Formula | None) -> Sequence[Action]:
    def reached(node: PlanNode) -> bool:
        holds = walk.planner.holds
        if node.met < len(asked.actions) or not all(holds(c, node.state) for c in asked.conditions):
            return False
        return over_time is None or semantics.holds(over_time, to_trace(_course(node)))

    return drop_needless_actions(walk.planner.domain, walk.start, walk.trail, reached, asked.actions)


def _course(node: PlanNode) -> Trajectory:
    """The way to a node."""
    steps = [Step(action, None) for action in node.plan()]
    return Trajectory(tuple([each.state for each in node.path()]), tuple(steps))


def lower_bound(task: Task, domain: Domain, depth: int) -> int:
    """How many actions a plan has at least: all that are shorter, up to this depth, were tried.

    It is the length of a shortest plan if that is not longer than the depth, and else the depth and one.
    """
    test, at_the_end = GoalTest(task), GoalTest(task.at_the_end)
    generator = SuccessorGenerator(domain, range(len(task.scene.objects)))
    nodes: list[PlanNode] = [Node(task.initial)]
    seen = {task.initial}
    forgetful = not test.watches and not task.goals_of(GoalKind.ACTION)
    for length in range(1, depth + 1):
        nodes, parents = [], nodes
        for parent in parents:
            for action in generator.applicable(parent):
                after = domain.apply(parent.state, action)
                node = Node(after, depth=length, parent=parent, actions=(action,))
                operators = [each.operator for each in node.plan()]
                if all(at_the_end.reached(after, operators)) and (
                    not test.watches or all(test.reached(after, operators, _course(node)))
                ):
                    return length
                if not (forgetful and after in seen):
                    seen.add(after)
                    nodes.append(node)
    return depth + 1


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
        return to_trace(self.trajectory)

    def comes_first(self, first: f.Atom, then: f.Atom) -> bool:
        """Whether one thing is not so before another is."""
        return self.became[first][0] <= self.became[then][0]

    def has_both(self, one: f.Atom, other: f.Atom) -> bool:
        """Whether two things are ever so at once."""
        return not set(self.became[one]).isdisjoint(self.became[other])


@dataclass(frozen=True)
class Seeker:
    """Looks for a goal over time.

    Attributes:
        task: for a task with a certificate.
        domain: in which plans are executed.
        listings: what goals can say.
        proposals: what may be seen on a detour.
        rng: chooses.
        begin: begins a walk where the task does, by what is usual.
    """

    task: Task
    domain: Domain
    listings: Sequence[FactListing]
    proposals: Proposals
    rng: random.Random
    begin: Callable[[], Walk]

    def find(self) -> _OverTime | None:
        """A goal over time, or None if none is found."""
        if self.task.goals_of(GoalKind.ACTION):
            return None
        ways = [self._after_a_detour, self._tidily, self._in_order]
        found = (way() for way in self.rng.sample(ways, len(ways)))
        return next((each for each in found if each is not None), None)

    @cached_property
    def _goals(self) -> Sequence[f.Formula]:
        return [goal.formula for goal in self.task.goals]

    @cached_property
    def _ours(self) -> _Course:
        return self._course(self.task.script)

    def _course(self, plan: Sequence[Action]) -> _Course:
        trajectory = execute(self.domain, self.task.initial, plan)
        return _Course(plan, trajectory, self._became(trajectory.states))

    def _after_a_detour(self) -> _OverTime | None:
        """Something that is to be so before a goal is reached, and not in the end."""
        walk, seen, last = self.begin(), self.proposals.literal(self.rng), self.rng.choice(self._goals)
        if seen is None or not isinstance(last, f.Atom | f.Not) or not walk.reach(seen):
            return None
        walk.conditions.clear()
        reached = walk.follow(self.task.script, self._goals) or reach_all(walk, self._goals)
        if not reached or walk.holds(seen, walk.state):
            return None
        goal = f.Then((seen, last))
        kept = _if_it_matters(goal, self._course(walk.trail), self._ours)
        return None if kept is None else replace(kept, plan=certificate(walk, goal))

    def _tidily(self) -> _OverTime | None:
        """Never at once: a state that the certificate leaves behind (open, switched on), and another."""
        untidy, goals, rng = self._ours, self._goals, self.rng
        last = len(untidy.plan)
        left = [
            atom
            for atom, when in untidy.became.items()
            if len(atom.arguments) == 1 and atom not in goals and when[-1] == last
        ]
        if not left:
            return None
        never = rng.choice(left)
        cuts = [cut for cut in self._cuts if cut >= untidy.became[never][0]]
        for cut in cuts[:_TIDY]:
            walk = self.begin()
            if (
                walk.follow(untidy.plan[:cut], ())
                and walk.reach(f.Not(never))
                and walk.follow(untidy.plan[cut:], goals)
            ):
                tidy = self._course(walk.trail)
                for other in rng.sample(list(untidy.became), len(untidy.became)):
                    goal = f.Always(f.Not(f.And((never, other))))
                    kept = _if_it_matters(goal, tidy, untidy) if other != never else None
                    if kept is not None:
                        walk.conditions = list(goals)
                        return replace(kept, plan=certificate(walk, goal))
        return None

    def _in_order(self) -> _OverTime | None:
        """An order that the certificate keeps, and the same actions in another order do not."""
        ours, goals, rng = self._ours, self._goals, self.rng
        parts = [ours.plan[i:j] for i, j in pairwise([0, *self._cuts])]
        for _ in range(_SHUFFLES if len(parts) > 1 else 0):
            found = self._between(list(chain(*rng.sample(parts, len(parts)))))
            if found is not None:
                return found
        walk = self.begin()
        if len(goals) > 1 and reach_all(walk, rng.sample(goals, len(goals))):
            return self._between(certificate(walk))
        return None

    @cached_property
    def _cuts(self) -> list[int]:
        """After how many steps of the certificate one goal more holds to the end."""
        states = list(enumerate(self._ours.trajectory.states))[::-1]
        missed = (
            next(i for i, state in states if not self.domain.holds(goal, state)) for goal in self._goals
        )
        return sorted({i + 1 for i in missed})

    def _between(self, plan: Sequence[Action]) -> _OverTime | None:
        """A goal that holds on our way, and not on that of another plan; rather about one thing."""
        other = self._course(plan)
        final = other.trajectory.final
        if other.trajectory.failure is not None or not all(self.domain.holds(g, final) for g in self._goals):
            return None
        candidates = list(self._candidates(other))
        self.rng.shuffle(candidates)
        candidates.sort(key=itemgetter(0))
        kept = (_if_it_matters(goal, self._ours, other) for _, goal in candidates)
        return next((found for found in kept if found is not None), None)

    def _candidates(self, other: _Course) -> Iterator[tuple[bool, f.Formula]]:
        """Goals that may tell our way from another, and whether what they name has no object in common."""
        ours, things = self._ours, self.task.scene.objects
        both = [atom for atom in ours.became if atom in other.became]
        for first, then in permutations(both, 2):
            if ours.comes_first(first, then) and not other.comes_first(first, then):
                yield _are_apart(then, first), f.Until(f.Not(then), first)
            if object_names(first) < object_names(then) and other.has_both(first, then) > ours.has_both(
                first, then
            ):
                yield _are_apart(first, then), f.Always(f.Not(f.And((first, then))))
        wanted = {name for alternatives in self.proposals.prior.actions for name in alternatives}
        for action in ours.plan:
            if action.operator in wanted and action.arguments:
                names = [f.Constant(things[i].name) for i in action.arguments]
                done = f.Occurs(action.operator, tuple(names))
                yield from ((_are_apart(then, done), f.Until(f.Not(then), done)) for then in both)

    def _became(self, states: Sequence[State]) -> Mapping[f.Atom, Sequence[int]]:
        """The facts that came to hold, with the states, as far as goals say them of things."""
        things, agent, about = self.task.scene.objects, self.task.scene.agent, self.task.relevant
        found: dict[Fact, list[int]] = {}
        for each in self.listings:
            if (each.predicate, True) in self.proposals.prior.wanted:
                at_start = set(each.facts(states[0], about))
                for number, state in enumerate(states):
                    for fact in each.facts(state, about):
                        if fact not in at_start:
                            found.setdefault(fact, []).append(number)
        return {
            f.Atom(fact.predicate, tuple([f.Constant(things[i].name) for i in fact.arguments])): when
            for fact, when in found.items()
            if agent not in fact.arguments and self._moves(fact)
        }

    def _moves(self, fact: Fact) -> bool:
        """Whether a fact is a state, or the place of a thing that is ever taken in hand."""
        if len(fact.arguments) != 2:
            return len(fact.arguments) < 2
        moved, prior = self.task.scene.objects[fact.arguments[0]].category, self.proposals.prior
        return not prior.kinds or moved in prior.taken


def _if_it_matters(goal: f.Formula, ours: _Course, other: _Course) -> _OverTime | None:
    """The goal, if it holds on our way and not on the other."""
    kept, tempted = [semantics.holds(goal, course.timeline) for course in (ours, other)]
    return _OverTime(goal, ours.plan, other.plan) if kept and not tempted else None


def reach_all(walk: Walk, goals: Sequence[f.Formula]) -> bool:
    """Reach goals in an order, and tell whether all hold in the end."""
    for wanted in goals:
        if walk.holds(wanted, walk.state):
            walk.conditions.append(wanted)
        elif not walk.reach(wanted):
            return False
    return all(walk.holds(wanted, walk.state) for wanted in goals)


def _are_apart(one: f.Formula, other: f.Formula) -> bool:
    """Whether two things that are said have no object in common."""
    return set(object_names(one)).isdisjoint(object_names(other))
