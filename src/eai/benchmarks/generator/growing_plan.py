"""Extend a plan goal by goal, shorten the plan, and find temporal goals.

A temporal goal is a condition on the whole course of an episode. It comes from two plans that reach the same
final goals. The first plan is the shortened plan that solves the task. The second plan, a *temptation*,
reaches the goals in another order or without a detour. The temporal goal says which fact must come first, or
which facts must never hold together. Only the first plan fulfils it, so the goal is possible and excludes the
temptation.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise, permutations
from operator import itemgetter
from typing import NamedTuple, TypeAlias

import eai.logic.formula as f
import eai.logic.semantics as semantics
from eai.benchmarks.generator.goals import GoalSampler
from eai.logic.trace import Trace
from eai.logic.traversal import find_object_names
from eai.planning.planner import Planner, PlanningGoal, drop_needless_actions
from eai.planning.search import Limits, SearchEndReason, SearchNode
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.tasks.goal_test import GoalTest
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, execute_plan, to_trace
from eai.world.listing import FactLister
from eai.world.state import Fact, State

_GOAL_LIMITS = Limits(20, thorough=False)
"""Limits of the search for actions that reach one more goal."""

_SHORTENING_LIMITS = Limits(300)
"""Limits of the search for a shorter plan that reaches all goals of a plan under construction."""

_MIN_STEPS_TO_SHORTEN = 25
"""Minimum number of steps of a plan for which the planner searches a shorter plan."""

_MAX_ORDERS = 6
"""Maximum number of times that parts of the solving plan are put into another random order.

A temporal goal is sought that the solving plan fulfils and the reordered plan fails. The reordered plan must
still reach the task's final goals.
"""

_SortKey: TypeAlias = bool

_MAX_TIDY_POSITIONS = 3
"""Maximum number of positions in the solving plan at which actions that undo a fact are inserted."""


class _PlanCheckpoint(NamedTuple):
    """The state of a growing plan (`GoalByGoalPlan`) and the lengths of its lists at one time."""

    state: State
    conditions: int
    actions: int
    goals: int
    trail: int


@dataclass
class GoalByGoalPlan:
    """A plan that grows goal by goal: actions that reach the next goal are appended.

    Attributes:
        planner: finds actions for the next goal.
        state: current state.
        start: initial state.
        conditions: reached goals about states, which must stay true.
        actions: reached goals for actions, in order. Each goal lists operators: an action with one listed
            operator reaches the goal.
        goals: all reached goals, in order.
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
    def scene_object_indices(self) -> tuple[int, ...]:
        """Indices of all objects of the scene, as possible arguments of actions."""
        return tuple(range(len(self.state.scene.objects)))

    def get_plan_checkpoint(self) -> _PlanCheckpoint:
        """Return the current end of the plan, to which `go_back_to` can return."""
        return _PlanCheckpoint(
            self.state, len(self.conditions), len(self.actions), len(self.goals), len(self.trail)
        )

    def go_back_to(self, checkpoint: _PlanCheckpoint) -> None:
        """Undo all actions and goals that were added after a checkpoint."""
        self.state, conditions, actions, goals, trail = checkpoint
        del self.conditions[conditions:], self.actions[actions:], self.goals[goals:], self.trail[trail:]

    def goal_holds(self, wanted: f.Formula, state: State) -> bool:
        """Whether a goal about states holds in a state; False for goals about actions."""
        return not _list_operators_for_action_goal(wanted) and self.planner.holds(wanted, state)

    def reach_goal(self, wanted: f.Formula) -> bool:
        """Append actions that reach one more goal, and return True.

        Return False, and change nothing, if the goal holds already or no plan is found.
        """
        names = _list_operators_for_action_goal(wanted)
        if names:
            planning_goal = PlanningGoal(tuple(self.conditions), (names,))
        elif self.goal_holds(wanted, self.state):
            return False
        else:
            planning_goal = PlanningGoal((*self.conditions, wanted))
        search = self.planner.find_plan(self.state, planning_goal, self.scene_object_indices, _GOAL_LIMITS)
        if search.end is not SearchEndReason.SOLVED:
            return False
        for action in search.plan:
            self.state = self.planner.domain.apply(self.state, action)
        self.trail += search.plan
        self.goals.append(wanted)
        if names:
            self.actions.append(names)
        else:
            self.conditions.append(wanted)
        return True

    def append_plan_if_it_reaches_goals(self, plan: Sequence[Action], goals: Sequence[f.Formula]) -> bool:
        """Append the actions of another plan if it reaches the given goals about states.

        Return whether the other plan reaches the goals. If not, nothing changes.
        """
        course = execute_plan(self.planner.domain, self.state, plan)
        if course.failure is not None or not all(self.goal_holds(goal, course.final_state) for goal in goals):
            return False
        self.state = course.final_state
        self.trail += plan
        self.goals += goals
        self.conditions += goals
        return True


def _list_operators_for_action_goal(wanted: f.Formula) -> tuple[str, ...]:
    """Return the operators that a goal names: the goal requires an action of one of them.

    A goal about states gives no operators.
    """
    parts = f.get_operands(wanted, f.Or)
    return tuple([part.action for part in parts if isinstance(part, f.Occurs)])


def make_shortened_plan(
    growing_plan: GoalByGoalPlan, temporal_goal: f.Formula | None = None
) -> Sequence[Action]:
    """Return a short plan that reaches the goals that `growing_plan` has reached.

    This is the growing plan without needless actions. If it is still long, it is a shorter plan of the
    planner, if one is found. The planner is not used with a temporal goal, which it cannot handle.
    """
    planning_goal = PlanningGoal(tuple(growing_plan.conditions), tuple(growing_plan.actions))
    grown = _drop_needless_actions(growing_plan, planning_goal, temporal_goal)
    if len(grown) < _MIN_STEPS_TO_SHORTEN or temporal_goal is not None:
        return grown
    plan = growing_plan.planner.find_plan(
        growing_plan.start, planning_goal, growing_plan.scene_object_indices, _SHORTENING_LIMITS
    ).plan
    return plan if 0 < len(plan) < len(grown) else grown


def _drop_needless_actions(
    growing_plan: GoalByGoalPlan, planning_goal: PlanningGoal, temporal_goal: f.Formula | None
) -> Sequence[Action]:
    def reaches_all_goals(node: PlanNode) -> bool:
        holds = growing_plan.planner.holds
        if node.met < len(planning_goal.actions) or not all(
            holds(c, node.state) for c in planning_goal.conditions
        ):
            return False
        return temporal_goal is None or semantics.holds(temporal_goal, to_trace(_make_trajectory(node)))

    return drop_needless_actions(
        growing_plan.planner.domain,
        growing_plan.start,
        growing_plan.trail,
        reaches_all_goals,
        planning_goal.actions,
    )


def _make_trajectory(node: PlanNode) -> Trajectory:
    steps = [Step(action, None) for action in node.list_actions()]
    return Trajectory(tuple([ancestor.state for ancestor in node.list_path_nodes()]), tuple(steps))


def find_min_plan_length(task: Task, domain: Domain, depth: int) -> int:
    """Return a lower bound of the number of actions of any plan, found by trying all plans up to a depth.

    The bound is the length of a shortest plan of at most this depth. If no such plan exists, it is the depth
    plus one.
    """
    test, at_the_end = GoalTest(task), GoalTest(task.without_goals_over_time)
    generator = SuccessorGenerator(domain, range(len(task.scene.objects)))
    nodes: list[PlanNode] = [SearchNode(task.initial)]
    seen = {task.initial}
    forgetful = not test.has_goals_over_time and not task.get_goals_of_kind(GoalKind.ACTION)
    for length in range(1, depth + 1):
        nodes, parents = [], nodes
        for parent in parents:
            for action in generator.generate_applicable_actions(parent):
                after = domain.apply(parent.state, action)
                node = SearchNode(after, depth=length, parent=parent, actions=(action,))
                operators = [step.operator for step in node.list_actions()]
                if all(at_the_end.evaluate_each_goal(after, operators)) and (
                    not test.has_goals_over_time
                    or all(test.evaluate_each_goal(after, operators, _make_trajectory(node)))
                ):
                    return length
                if not (forgetful and after in seen):
                    seen.add(after)
                    nodes.append(node)
    return depth + 1


@dataclass(frozen=True)
class _TemporalGoal:
    """A goal about an order or forbidden facts, a plan that fulfils it, and its `temptation`.

    The temptation is a plan that reaches all other goals, but not this goal.
    """

    goal: f.Formula
    plan: Sequence[Action]
    temptation: Sequence[Action]


@dataclass(frozen=True)
class _ExecutedPlan:
    """An executed plan, with the facts that it makes true.

    Attributes:
        plan: the plan.
        trajectory: the states of its execution.
        new_facts: fact that the plan makes true -> indices of the states in which the fact holds.
    """

    plan: Sequence[Action]
    trajectory: Trajectory
    new_facts: Mapping[f.Atom, Sequence[int]]

    @cached_property
    def trace_of_execution(self) -> Trace:
        return to_trace(self.trajectory)

    def becomes_true_first(self, first: f.Atom, then: f.Atom) -> bool:
        """Whether a plan makes the first fact true no later than the second fact."""
        return self.new_facts[first][0] <= self.new_facts[then][0]

    def have_held_together(self, one: f.Atom, other: f.Atom) -> bool:
        """Whether two facts hold in the same state at some time of the execution."""
        return not set(self.new_facts[one]).isdisjoint(self.new_facts[other])


@dataclass(frozen=True)
class TemporalGoalGenerator:
    """Finds a temporal goal for a task: facts in a certain order, or facts that must never hold together.

    Attributes:
        task: a task with a plan.
        domain: the domain in which plans are executed.
        listings: for each predicate, an object that lists the facts of this predicate in a state. Temporal
            goals are about such facts.
        proposals: draws random facts, for temporal goals that require a detour.
        rng: the random generator.
        begin: returns an empty plan in the task's initial state, to which actions can be added. Its planner
            uses only actions that resemble actions in plans of the data set.
    """

    task: Task
    domain: Domain
    listings: Sequence[FactLister]
    proposals: GoalSampler
    rng: random.Random
    begin: Callable[[], GoalByGoalPlan]

    def find_temporal_goal(self) -> _TemporalGoal | None:
        """Return a temporal goal (an order, forbidden facts) with two plans, or None if none is found.

        Both plans reach the task's final goals. Only the first plan fulfils the temporal goal.
        """
        if self.task.get_goals_of_kind(GoalKind.ACTION):
            return None
        ways = [
            self._find_goal_requiring_intermediate_fact,
            self._find_goal_that_forbids_a_side_effect,
            self._find_goal_about_order,
        ]
        candidates = (way() for way in self.rng.sample(ways, len(ways)))
        return next((candidate for candidate in candidates if candidate is not None), None)

    @cached_property
    def _goals(self) -> Sequence[f.Formula]:
        return [goal.formula for goal in self.task.goals]

    @cached_property
    def _solving_plan(self) -> _ExecutedPlan:
        return self._execute_plan(self.task.script)

    def _execute_plan(self, plan: Sequence[Action]) -> _ExecutedPlan:
        trajectory = execute_plan(self.domain, self.task.initial, plan)
        return _ExecutedPlan(plan, trajectory, self._map_new_facts_to_state_indices(trajectory.states))

    def _find_goal_requiring_intermediate_fact(self) -> _TemporalGoal | None:
        """Return a temporal goal that requires a detour, or None if none is found.

        A fact must become true before one of the task's goals. At the end of the plan, the fact is false.
        """
        growing_plan = self.begin()
        seen = self.proposals.draw_literal(self.rng)
        last = self.rng.choice(self._goals)
        if seen is None or not isinstance(last, f.Atom | f.Not) or not growing_plan.reach_goal(seen):
            return None
        growing_plan.conditions.clear()
        reached = growing_plan.append_plan_if_it_reaches_goals(
            self.task.script, self._goals
        ) or try_to_reach_goals_in_order(growing_plan, self._goals)
        if not reached or growing_plan.goal_holds(seen, growing_plan.state):
            return None
        goal = f.Then((seen, last))
        kept = _make_goal_if_only_first_fulfils(
            goal, self._execute_plan(growing_plan.trail), self._solving_plan
        )
        return None if kept is None else replace(kept, plan=make_shortened_plan(growing_plan, goal))

    def _find_goal_that_forbids_a_side_effect(self) -> _TemporalGoal | None:
        """Return a temporal goal that forbids two facts to hold together, or None if none is found.

        One of the facts is a side effect that the solving plan does not undo.
        """
        untidy, goals, rng = self._solving_plan, self._goals, self.rng
        last = len(untidy.plan)
        left = [
            atom
            for atom, when in untidy.new_facts.items()
            if len(atom.arguments) == 1 and atom not in goals and when[-1] == last
        ]
        if not left:
            return None
        never = rng.choice(left)
        cuts = [cut for cut in self._steps_reaching_goals if cut >= untidy.new_facts[never][0]]
        for cut in cuts[:_MAX_TIDY_POSITIONS]:
            growing_plan = self.begin()
            if (
                growing_plan.append_plan_if_it_reaches_goals(untidy.plan[:cut], ())
                and growing_plan.reach_goal(f.Not(never))
                and growing_plan.append_plan_if_it_reaches_goals(untidy.plan[cut:], goals)
            ):
                tidy = self._execute_plan(growing_plan.trail)
                for other in rng.sample(list(untidy.new_facts), len(untidy.new_facts)):
                    goal = f.Always(f.Not(f.And((never, other))))
                    kept = _make_goal_if_only_first_fulfils(goal, tidy, untidy) if other != never else None
                    if kept is not None:
                        growing_plan.conditions = list(goals)
                        return replace(kept, plan=make_shortened_plan(growing_plan, goal))
        return None

    def _find_goal_about_order(self) -> _TemporalGoal | None:
        """Return a goal about the order of facts that the solving plan fulfils and a reordered plan fails."""
        ours, goals, rng = self._solving_plan, self._goals, self.rng
        parts = [ours.plan[i:j] for i, j in pairwise([0, *self._steps_reaching_goals])]
        for _ in range(_MAX_ORDERS if len(parts) > 1 else 0):
            temporal = self._find_goal_that_plan_fails(list(chain(*rng.sample(parts, len(parts)))))
            if temporal is not None:
                return temporal
        growing_plan = self.begin()
        if len(goals) > 1 and try_to_reach_goals_in_order(growing_plan, rng.sample(goals, len(goals))):
            return self._find_goal_that_plan_fails(make_shortened_plan(growing_plan))
        return None

    @cached_property
    def _steps_reaching_goals(self) -> list[int]:
        """Numbers of steps of the solving plan after which a further goal holds until the end, ascending."""
        states = list(enumerate(self._solving_plan.trajectory.states))[::-1]
        missed = (
            next(i for i, state in states if not self.domain.holds(goal, state)) for goal in self._goals
        )
        return sorted({i + 1 for i in missed})

    def _find_goal_that_plan_fails(self, plan: Sequence[Action]) -> _TemporalGoal | None:
        """Return a temporal goal that the solving plan fulfils and another plan fails, or None.

        Goals whose facts share an object come first.
        """
        other = self._execute_plan(plan)
        final = other.trajectory.final_state
        if other.trajectory.failure is not None or not all(self.domain.holds(g, final) for g in self._goals):
            return None
        candidates = list(self._propose_goals_that_plan_fails(other))
        self.rng.shuffle(candidates)
        candidates.sort(key=itemgetter(0))
        kept = (_make_goal_if_only_first_fulfils(goal, self._solving_plan, other) for _, goal in candidates)
        return next((candidate for candidate in kept if candidate is not None), None)

    def _propose_goals_that_plan_fails(
        self, failing_plan: _ExecutedPlan
    ) -> Iterator[tuple[_SortKey, f.Formula]]:
        """Yield candidates for a temporal goal that the solving plan fulfils and `failing_plan` fails.

        Each candidate is a pair: a sort key and the goal. The sort key is False if the facts of the goal
        share an object. The caller tests the candidates.
        """
        ours, things = self._solving_plan, self.task.scene.objects
        both = [atom for atom in ours.new_facts if atom in failing_plan.new_facts]
        for first, then in permutations(both, 2):
            if ours.becomes_true_first(first, then) and not failing_plan.becomes_true_first(first, then):
                yield _have_no_common_object(then, first), f.Until(f.Not(then), first)
            if find_object_names(first) < find_object_names(then) and failing_plan.have_held_together(
                first, then
            ) > ours.have_held_together(first, then):
                yield _have_no_common_object(first, then), f.Always(f.Not(f.And((first, then))))
        wanted = {name for alternatives in self.proposals.usual_goals.action_counts for name in alternatives}
        for action in ours.plan:
            if action.operator in wanted and action.arguments:
                names = [f.Constant(things[i].name) for i in action.arguments]
                done = f.Occurs(action.operator, tuple(names))
                yield from ((_have_no_common_object(then, done), f.Until(f.Not(then), done)) for then in both)

    def _map_new_facts_to_state_indices(self, states: Sequence[State]) -> Mapping[f.Atom, Sequence[int]]:
        """Return the new facts that may be goals, each with the indices of the states in which it holds.

        A fact is new if it does not hold in the first state.
        """
        things, agent, about = self.task.scene.objects, self.task.scene.agent, self.task.relevant
        new_facts: dict[Fact, list[int]] = {}
        for listing in self.listings:
            if (listing.predicate, True) in self.proposals.usual_goals.goal_counts:
                at_start = set(listing.list_facts(states[0], about))
                for number, state in enumerate(states):
                    for fact in listing.list_facts(state, about):
                        if fact not in at_start:
                            new_facts.setdefault(fact, []).append(number)
        return {
            f.Atom(fact.predicate, tuple([f.Constant(things[i].name) for i in fact.arguments])): when
            for fact, when in new_facts.items()
            if agent not in fact.arguments and self._may_plans_of_data_set_change_fact(fact)
        }

    def _may_plans_of_data_set_change_fact(self, fact: Fact) -> bool:
        """Whether plans of the data set may change facts of this form.

        They may change every fact about fewer than two objects. They may change a fact about two objects if
        they pick up objects of the first object's category, or if the data set has no plans.
        """
        if len(fact.arguments) != 2:
            return len(fact.arguments) < 2
        moved, usual_goals = self.task.scene.objects[fact.arguments[0]].category, self.proposals.usual_goals
        return not usual_goals.uses or moved in usual_goals.taken_categories


def _make_goal_if_only_first_fulfils(
    goal: f.Formula, first_plan: _ExecutedPlan, second_plan: _ExecutedPlan
) -> _TemporalGoal | None:
    """Return a temporal goal (order, forbidden facts) that only the first of two plans fulfils, or None."""
    is_kept, is_kept_by_other = [
        semantics.holds(goal, course.trace_of_execution) for course in (first_plan, second_plan)
    ]
    if is_kept and not is_kept_by_other:
        return _TemporalGoal(goal, first_plan.plan, second_plan.plan)
    return None


def try_to_reach_goals_in_order(growing_plan: GoalByGoalPlan, goals: Sequence[f.Formula]) -> bool:
    """Append actions that reach the goals one after the other. Return whether all goals hold at the end."""
    for wanted in goals:
        if growing_plan.goal_holds(wanted, growing_plan.state):
            growing_plan.conditions.append(wanted)
        elif not growing_plan.reach_goal(wanted):
            return False
    return all(growing_plan.goal_holds(wanted, growing_plan.state) for wanted in goals)


def _have_no_common_object(one: f.Formula, other: f.Formula) -> bool:
    """Whether no object occurs in both formulas."""
    return set(find_object_names(one)).isdisjoint(find_object_names(other))
