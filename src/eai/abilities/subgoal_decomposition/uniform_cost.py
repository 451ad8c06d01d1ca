"""Uniform-cost search for the shortest plans that reach a subgoal from a state.

The search may use actions that may reach the subgoal, and actions that may make such actions possible.
`refinement` permits these actions in larger and larger sets. Before each action the agent makes the shortest
movement that the action needs. If no plan is found, the result is the failed plan that comes nearest to the
subgoal. It usually ends with an action whose checks fail, which is then the reported fault. This module
shares nodes, open list and loop with `eai.planning.planner`. It is separate because a subgoal needs several
shortest plans, and the planner returns only one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from copy import copy
from itertools import tee
from typing import NamedTuple, TypeAlias

from eai.abilities.subgoal_decomposition.program import (
    MAX_ACTIONS_PER_SUBGOAL,
    TOO_FAR,
    ActionSequence,
    SubgoalPlanningResult,
)
from eai.abilities.subgoal_decomposition.repertoire import CandidateAction, Holds, select_actions_of_operators
from eai.planning.search import OpenList, SearchEffort, SearchEndReason, SearchNode, run_best_first_search
from eai.planning.successor_generator import PlanNode
from eai.world.action import Action
from eai.world.state import State

MAX_PLANS_PER_SUBGOAL = 4
"""Maximum number of plans that a search returns for one subgoal."""

_PARTS_PER_ACTION = 16
"""Number of tests of the goal's literals that cost as much effort as one applied action."""

_MAX_MOVEMENTS = 3
"""Maximum number of movements before one action: to stand up, to go to an object, and to turn to it."""


MovementPath: TypeAlias = PlanNode
"""A path of movements from a state: a search node with the movements and the state after them."""


class PermittedActions(NamedTuple):
    """The actions that a search may use.

    Parts are the literals of the subgoal; a mask has a bit for each part.

    Attributes:
        achievers: actions that may make parts true, except those in ``moving``.
        helping: actions that take or release objects, and so may make achievers possible.
        moving: movements that may make parts true.
        movement: movements that may make other actions possible.
        touched: mask of the parts that the actions in ``movement`` can change.
    """

    achievers: Sequence[CandidateAction]
    helping: Sequence[CandidateAction]
    moving: Sequence[CandidateAction]
    movement: Sequence[CandidateAction]
    touched: int


class SearchGoal(NamedTuple):
    """The goal of a search. Its parts are literals; a mask has a bit for each part.

    Attributes:
        at_start: mask of the parts that hold in the start state.
        met: takes a state, a mask of parts to test and the mask of parts that held before; returns the mask
            of parts that hold now.
        everything: mask of all parts.
        holds: tests in a state what the goal requires in addition to its parts.
        distinguished: operators whose use matters to the goal, even if the resulting states are equal.
        effort: cost of `holds`, in applied actions.
    """

    at_start: int
    met: Callable[[State, int, int], int]
    everything: int
    holds: Holds
    distinguished: Collection[str]
    effort: int = 0

    @property
    def goal_part_count(self) -> int:
        """Number of literals of the goal."""
        return self.everything.bit_count()

    @property
    def effort_per_search_step(self) -> int:
        """Effort of one step of the search: one applied action, and a test of all literals of the goal.

        The unit is one applied action.
        """
        return 1 + self.goal_part_count // _PARTS_PER_ACTION


def find_plans_trying_action_sets_in_order(
    goal: SearchGoal,
    permitted_action_sets: Iterable[PermittedActions],
    start: State,
    max_applied_actions_per_search: int,
) -> SubgoalPlanningResult:
    """Return the shortest plans that reach a goal, or the failed plan that comes nearest to the goal.

    The sets of permitted actions are tried in order, until a plan is found.

    Args:
        goal: the goal of the searches.
        permitted_action_sets: the sets of permitted actions, one for each search.
        start: the state in which plans begin.
        max_applied_actions_per_search: maximum number of actions that each search may apply to states.
    """
    failed: list[_UniformCostSearch] = []
    effort = 0
    for permitted in permitted_action_sets:
        search = _UniformCostSearch(goal, permitted, max_applied_actions_per_search)
        plans = search.find_shortest_plans(start)
        effort += search.effort.used * goal.effort_per_search_step
        if plans:
            return SubgoalPlanningResult(plans, effort)
        failed.append(search)
    attempt = _find_best_failed_plan(failed)
    return attempt._replace(effort=effort + attempt.effort)


class _MovementPathFinder:
    """Finds paths of movements from states. A path is explored only when an action may need it.

    Args:
        moves: actions that move the agent.
        effort: the limit of applied actions.
    """

    def __init__(self, moves: Sequence[CandidateAction], effort: SearchEffort) -> None:
        self._moves = moves
        self._effort = effort
        self._paths: dict[State, Iterator[MovementPath]] = {}

    def __bool__(self) -> bool:
        return bool(self._moves)

    def list_paths(self, state: State) -> Iterable[MovementPath]:
        """Yield the shortest movement path to each state that movement can reach, the shortest path first.

        A path has at most `_MAX_MOVEMENTS` movements, each by another operator. Paths are explored lazily.
        """
        if state not in self._paths:
            (self._paths[state],) = tee(self._explore_paths(state), 1)
        # Each copy of the iterator starts at the shortest path, and no path is computed twice.
        return copy(self._paths[state])

    def _explore_paths(self, start: State) -> Iterator[MovementPath]:
        moves = [candidate for candidate in self._moves if candidate.static_checks_hold(start)]
        seen = {start}
        paths: list[MovementPath] = [SearchNode(start)]
        for _ in range(_MAX_MOVEMENTS):
            longer_paths: list[MovementPath] = []
            for path in paths:
                taken = [action.operator for action in path.list_actions()]
                for candidate in moves:
                    if candidate.action.operator in taken or self._effort.is_limit_reached:
                        continue
                    if candidate.info.common_checks_hold(
                        path.state, candidate.binding
                    ) and candidate.remaining_checks_hold(path.state):
                        self._effort.used += 1
                        after = candidate.compute_state_after_action(path.state)
                        if after not in seen:
                            seen.add(after)
                            longer_paths.append(
                                SearchNode(after, 0, path.depth + 1, path, (candidate.action,))
                            )
                            yield longer_paths[-1]
            paths = longer_paths


class _UniformCostSearch:
    """A search for the shortest plans of at most `MAX_ACTIONS_PER_SUBGOAL` actions.

    The attribute ``met`` of a node is the bit mask of the goal's literals that hold in the node's state.

    Args:
        goal: the goal.
        permitted: the permitted actions.
        budget: maximum number of actions applied to states.

    Attributes:
        goal: the goal.
        permitted: the permitted actions.
        effort: number of actions applied to states.
        movement: finds movement paths.
        nodes: nodes of the visited states in which the goal does not hold, in order of distance from the
            start.
        out_of_reach: pairs of a state and an action that no movement makes possible in this state.
    """

    def __init__(self, goal: SearchGoal, permitted: PermittedActions, budget: int) -> None:
        self.goal = goal
        self.permitted = permitted
        self.effort = SearchEffort(budget)
        self.movement = _MovementPathFinder(permitted.movement, self.effort)
        self.nodes: list[PlanNode] = []
        self.out_of_reach: set[tuple[State, Action]] = set()
        self._candidates: Sequence[CandidateAction] = ()
        self._open: OpenList[PlanNode] = OpenList()
        self._lengths: dict[State, int] = {}
        self._pushed = 0
        self._best = MAX_ACTIONS_PER_SUBGOAL
        self._found: dict[object, PlanNode] = {}

    def find_shortest_plans(self, start: State) -> list[ActionSequence]:
        """Return at most `MAX_PLANS_PER_SUBGOAL` shortest plans.

        If plans have the same end state and the same actions that matter to the goal, only one is returned.
        """
        actions = (*self.permitted.achievers, *self.permitted.helping)
        self._candidates = [candidate for candidate in actions if candidate.static_checks_hold(start)]
        self._push_node(SearchNode(start, self.goal.at_start))
        run_best_first_search(self._open.pop, self._expand_node_and_check_for_end)
        return [node.list_actions() for node in self._found.values()]

    def _push_node(self, node: PlanNode) -> None:
        self._lengths[node.state] = node.depth
        self._open.push(node, node.depth, self._pushed)
        self._pushed += 1

    def _expand_node_and_check_for_end(self, node: PlanNode) -> PlanNode | SearchEndReason | None:
        """Add the successors of a node to the open list, and keep those that reach the goal as solutions.

        Return the node of the last solution if enough solutions are found, or `SearchEndReason.STATES` if the
        effort is used up. Return None if the search continues.
        """
        self.nodes.append(node)
        if node.depth < self._best:
            for child in self._expand_node(node):
                if child.met == self.goal.everything and self._meets_goal(child.state):
                    self._keep_solution(child)
                    if len(self._found) == MAX_PLANS_PER_SUBGOAL:
                        return child
                elif child.depth < self._lengths.get(child.state, child.depth + 1):
                    self._push_node(child)
        return SearchEndReason.STATES if self.effort.is_limit_reached else None

    def _keep_solution(self, node: PlanNode) -> None:
        if node.depth < self._best:
            self._best = node.depth
            self._found = {}
        distinguished = select_actions_of_operators(node.list_actions(), self.goal.distinguished)
        self._found.setdefault((node.state, distinguished), node)

    def _meets_goal(self, state: State) -> bool:
        self.effort.used += self.goal.effort
        return self.goal.holds(state)

    def _expand_node(self, node: PlanNode) -> Iterator[PlanNode]:
        """Yield the successors of a node, except those with a longer plan than the best plan so far."""
        allowed: dict[str, bool] = {}
        without_movement: MovementPath = SearchNode(node.state)
        for candidate in self._candidates:
            is_world_changing, parts = candidate.is_world_changing, candidate.parts & ~node.met
            if is_world_changing and not parts:
                continue
            name = candidate.action.operator
            if name not in allowed:
                allowed[name] = candidate.info.common_checks_hold(node.state, candidate.binding)
            path = (
                self._find_enabling_movement(without_movement, node.depth + 1, candidate)
                if allowed[name]
                else None
            )
            if path is None:
                continue
            self.effort.used += 1
            after = candidate.compute_state_after_action(path.state)
            touched = candidate.touched | (self.permitted.touched if path.depth else 0)
            gained = self.goal.met(after, parts, 0) if is_world_changing else 0
            if is_world_changing and not gained:
                continue
            met = gained | self.goal.met(after, touched & ~parts if is_world_changing else touched, node.met)
            depth = node.depth + path.depth + 1
            yield SearchNode(after, met, depth, node, (*path.list_actions(), candidate.action))
        if self.permitted.moving:
            for path in self.movement.list_paths(node.state):
                depth = node.depth + path.depth
                if depth > self._best:
                    break
                met = self.goal.met(path.state, self.permitted.touched, node.met)
                if met & ~node.met:
                    yield SearchNode(path.state, met, depth, node, path.list_actions())

    def _find_enabling_movement(
        self, without_movement: MovementPath, before: int, candidate: CandidateAction
    ) -> MovementPath | None:
        """Return the shortest movement that makes an action possible, or None.

        The result is None if no movement does, or if the plan would be longer than the best plan so far.
        """
        state = without_movement.state
        if before > self._best:
            return None
        if candidate.remaining_checks_hold(state):
            return without_movement
        if not self.movement or not candidate.can_movement_make_action_possible(state):
            return None
        for path in self.movement.list_paths(state):
            if before + path.depth > self._best:
                return None
            if candidate.remaining_checks_hold(path.state):
                return path
        self.out_of_reach.add((state, candidate.action))
        return None


_MAX_FAILURE_STATES = 16
"""Maximum number of states in which actions are tested after a failed search: the start and best states."""

_MAX_FAILURE_TESTS = 200_000
"""Maximum number of tests of literals, over all states and actions, to explain a failed search.

If a goal has very many literals, they are tested in fewer states.
"""


_DistanceToSubgoal: TypeAlias = tuple[int, int, int]
"""Distance of a plan from reaching a subgoal, as three numbers that are compared in order.

The first number is minus the number of literals of the subgoal that the plan would make true. The other
numbers are the number of failing checks and the number of actions.
"""


class _ActionAttemptWithFailingChecks(NamedTuple):
    """An action that was tried after a plan, the state in which it was tried, and its failing checks."""

    node: PlanNode
    candidate: CandidateAction
    plan: tuple[Action, ...]
    state: State
    failing: list[int]


_NearestAttempt: TypeAlias = tuple[_DistanceToSubgoal, _ActionAttemptWithFailingChecks | None]
"""A pair: how far the best failed plan stays from the subgoal, and the failing action to report.

The action is None if the plan fails only because it is too long.
"""


_ProgressByActionsAndState: TypeAlias = dict[
    tuple[int, int, State, int], tuple[int, Sequence[tuple[CandidateAction, int]]]
]
"""Cache of the tests that several failed searches have in common.

The key has Python's ``id`` of both sequences of tested actions, the state in which they are tested, and the
mask of the goal's literals that hold in this state. The value has the number of tested actions. It also has
the actions after which more literals hold, each with the number of literals.
"""


def _find_best_failed_plan(searches: Sequence[_UniformCostSearch]) -> SubgoalPlanningResult:
    """Return the failed plan that comes nearest to the goal, after all searches failed.

    The plan ends with an action whose checks fail. Its effects, if they happened, would make most literals of
    the goal true. Ties go to the action with the fewest failing checks, then to the shortest plan. If the
    action needs an earlier action that fails, too, the plan may end with the earlier action
    (`_choose_failed_attempt_to_report`).

    If no action fails but the plan is too long, no plan is returned. If no failing action explains the
    failure, the plan leads to the visited state in which most literals hold. For example, each literal can be
    reached, but not all together.
    """
    progress: _ProgressByActionsAndState = {}
    failing = [_FailedSearch(search, progress) for search in searches]
    most_met = max([failed_search.most_met for failed_search in failing])
    farthest = [failed_search for failed_search in failing if failed_search.most_met == most_met]
    nearest_attempts = [
        nearest
        for failed_search in farthest
        if (nearest := failed_search.find_failed_plan_nearest_to_goal()) is not None
    ]
    effort = sum([failed_search.effort for failed_search in failing])
    if nearest_attempts:
        _, reported = min(nearest_attempts, key=lambda nearest: nearest[0])
        if reported is None:
            return SubgoalPlanningResult((), effort, TOO_FAR, has_failed=True)
        return SubgoalPlanningResult(
            (reported.plan,),
            effort,
            has_failed=not reported.candidate.needs_objects_of_other_kind(reported.failing),
        )
    nodes = [node for search in searches for node in search.nodes]
    most = max(nodes, key=lambda node: (node.met.bit_count(), -node.depth))
    return SubgoalPlanningResult((most.list_actions(),), effort, has_failed=True)


class _FailedSearch:
    """A search that found no plan, with the tests that explain the failure.

    Args:
        search: the search.
        progress: results of tests; new results are added.

    Attributes:
        effort: number of actions that were applied to states, or whose checks were tested, for the
            explanation.
        most_met: maximum number of the goal's literals that hold together in a visited state.
    """

    def __init__(self, search: _UniformCostSearch, progress: _ProgressByActionsAndState) -> None:
        self._progress = progress
        self._goal = search.goal
        self._permitted = search.permitted
        self._movement = search.movement
        self._out_of_reach = search.out_of_reach
        self.effort = 0
        start, *others = search.nodes
        self.most_met = max([node.met.bit_count() for node in search.nodes])
        others.sort(key=lambda node: -node.met.bit_count())
        tests = self._goal.goal_part_count * (len(self._permitted.achievers) + len(self._permitted.moving))
        self._nodes = [start, *others][
            : max(1, min(_MAX_FAILURE_STATES, _MAX_FAILURE_TESTS // max(1, tests)))
        ]

    def find_failed_plan_nearest_to_goal(self) -> _NearestAttempt | None:
        """Return the failed plan that comes nearest to the goal, or None if there is no plan to report.

        A failing action explains the failure if more literals of the goal would hold after the action than in
        any visited state. If no plan makes progress, an action that fails in the first state may be reported.
        """
        best: _ActionAttemptWithFailingChecks | None = None
        distance: _DistanceToSubgoal = (0, 0, 0)
        for node in self._nodes:
            for candidate, met in self._list_actions_with_progress(node):
                if best is not None and self._bound_distance_to_subgoal(node, candidate, met) >= distance:
                    continue
                attempt = self._try_action(node, candidate)
                if attempt.failing and met <= self.most_met:
                    continue
                attempt_distance = (-met, len(attempt.failing), len(attempt.plan))
                made = not attempt.failing and len(attempt.plan) <= MAX_ACTIONS_PER_SUBGOAL
                if not made and (best is None or attempt_distance < distance):
                    best, distance = attempt, attempt_distance
        if best is not None:
            return distance, self._choose_failed_attempt_to_report(best)
        first = self._nodes[0]
        # No plan makes progress: report the first action for which only its `OperatorAlternative`s fail.
        # A failing action before which another action must come counts, too; the other action is reported.
        for candidate in self._permitted.achievers:
            attempt = self._try_action(first, candidate)
            reported = self._choose_failed_attempt_to_report(attempt)
            only_tries = attempt.failing == [len(candidate.info.operator.checks)]
            if attempt.failing and (only_tries or reported is not attempt):
                return (0, len(attempt.failing), len(attempt.plan)), reported
        return None

    def _list_actions_with_progress(self, node: PlanNode) -> Sequence[tuple[CandidateAction, int]]:
        """Return the actions after which more literals of the goal would hold, with the number of literals.

        The checks of the actions are not tested.
        """
        achievers, moving = self._permitted.achievers, self._permitted.moving
        key = id(achievers), id(moving), node.state, node.met
        if key not in self._progress:
            tested = [candidate for candidate in (*achievers, *moving) if candidate.parts & ~node.met]
            numbers = [self._count_goal_parts_met_after_action(node, candidate) for candidate in tested]
            progress = [pair for pair in zip(tested, numbers, strict=True) if pair[1] > node.met.bit_count()]
            self._progress[key] = len(tested), progress
        number_of_tests, actions = self._progress[key]
        self.effort += number_of_tests * self._goal.effort_per_search_step
        return actions

    def _count_goal_parts_met_after_action(self, node: PlanNode, candidate: CandidateAction) -> int:
        after = candidate.compute_state_after_action(node.state)
        if not self._goal.met(after, candidate.parts & ~node.met, 0):
            return 0
        return self._goal.met(after, candidate.touched, node.met).bit_count()

    def _bound_distance_to_subgoal(
        self, node: PlanNode, candidate: CandidateAction, goal_parts_met: int
    ) -> _DistanceToSubgoal:
        lacking = candidate.count_failing_checks_movement_cannot_fix(node.state)
        return (
            -goal_parts_met,
            self._compute_lower_bound_on_failing_checks(node, candidate, lacking),
            node.depth + 1,
        )

    def _compute_lower_bound_on_failing_checks(
        self, node: PlanNode, candidate: CandidateAction, failures_unfixable_by_movement: int
    ) -> int:
        """Return a lower bound of the number of an action's checks that fail, whichever movement comes first.

        The bound is at least 1 if the search found no movement that makes the action possible.
        """
        return failures_unfixable_by_movement or int((node.state, candidate.action) in self._out_of_reach)

    def _try_action(self, node: PlanNode, candidate: CandidateAction) -> _ActionAttemptWithFailingChecks:
        """Try an action in a node's state. Move first if the action then fails fewer of its checks."""
        self.effort += 1
        failing = candidate.find_indices_of_failing_checks(node.state)
        best = _ActionAttemptWithFailingChecks(
            node, candidate, (*node.list_actions(), candidate.action), node.state, failing
        )
        least = self._compute_lower_bound_on_failing_checks(
            node, candidate, sum([not candidate.info.movable[i] for i in failing])
        )
        if len(failing) > least:
            for path in self._movement.list_paths(node.state):
                self.effort += 1
                failing = candidate.find_indices_of_failing_checks(path.state)
                if len(failing) < len(best.failing):
                    plan = (*node.list_actions(), *path.list_actions(), candidate.action)
                    best = _ActionAttemptWithFailingChecks(node, candidate, plan, path.state, failing)
                    if len(failing) == least:
                        break
        return best

    def _choose_failed_attempt_to_report(
        self, failed_attempt: _ActionAttemptWithFailingChecks
    ) -> _ActionAttemptWithFailingChecks | None:
        """Return the failed attempt at an action that is reported as the reason why a plan failed, or None.

        Usually this is ``failed_attempt``. But another action helps if ``failed_attempt`` would fail fewer
        checks after it. If all helping actions fail, the attempt at the first of them is reported instead.

        Return None if no check fails, or if a helping action is possible and keeps all true literals of the
        goal true. The plan then fails only because it is too long.
        """
        node, candidate, _, state, failing = failed_attempt
        if not failing:
            return None
        if candidate.needs_objects_of_other_kind(failing):
            return failed_attempt
        mending = [
            self._try_action(node, other)
            for other in self._permitted.helping
            if len(candidate.find_indices_of_failing_checks(other.compute_state_after_action(state)))
            < len(failing)
        ]
        if any(
            not tried_action.failing and self._keeps_met_goal_parts(tried_action) for tried_action in mending
        ):
            return None
        if mending and all(tried_action.failing for tried_action in mending):
            return mending[0]
        return failed_attempt

    def _keeps_met_goal_parts(self, attempt: _ActionAttemptWithFailingChecks) -> bool:
        node, candidate = attempt.node, attempt.candidate
        return (
            self._goal.met(candidate.compute_state_after_action(attempt.state), candidate.touched, node.met)
            == node.met
        )
