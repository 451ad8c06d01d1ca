"""The planner on declared domains. Plans take required operators in order and reach required conditions.

The goals are reached one after the other, each by a greedy best-first search (`greedy_search`). The search is
guided by the additive heuristic, computed backwards from the goal (`additive_heuristic`). A goal that must be
undone for another goal comes after the other goal (`_ReasonableOrder`). If no goal can be reached without
undoing another goal, a single search looks for all goals together. All actions of a plan are applicable. A
number of states limits the effort, never time. So equal input gives equal output.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence, Set
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from eai.base.grouping import group_pairs
from eai.logic.formula import Atom, Formula
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, CostEstimates
from eai.planning.greedy_search import GreedySearch
from eai.planning.search import Limits, SearchEndReason, SearchNode, SearchResult
from eai.planning.subgoal import GroundAtom, Subgoal, find_object_indices_of_arguments, make_subgoals
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import Scene, State

_FIRST_LIMITS = Limits(50, thorough=False)
"""Limits of the first search for one goal."""

_LIMIT_GROWTH = 4
"""Factor by which the maximum number of states grows when the search for each single goal has failed."""

_WHOLE_GOAL_FACTOR = 4
"""Factor by which a search may reach more states if it must reach all parts of a goal at once."""

_MAX_DIRECT_COST = 12.0
"""Maximum estimated cost of a goal that one search reaches directly.

For a costlier goal, the conditions that must hold before it are reached first.
"""

_MAX_KEPT_COST = 18.0
"""Estimated cost from which a goal counts as unreachable without undoing a goal that already holds."""

_NEXT_ACTION = -1
"""Index that stands for the goal to execute the next operator of `PlanningGoal.actions`.

Other goals have their indices in the list of goals.
"""


@dataclass(frozen=True, slots=True)
class PlanningGoal:
    """The goal of a plan.

    Attributes:
        conditions: closed state formulas that must hold at the end.
        actions: operators to take, one after the other, with any objects. Each entry lists the names of
            alternative operators.
    """

    conditions: tuple[Formula, ...]
    actions: tuple[tuple[str, ...], ...] = ()


def drop_needless_actions(
    domain: Domain,
    initial: State,
    plan: Sequence[Action],
    reached: Callable[[PlanNode], bool],
    actions: Sequence[Sequence[str]] = (),
) -> tuple[Action, ...]:
    """Return the actions of a plan that are needed for its goal; all actions if the plan misses the goal.

    Args:
        domain: the domain.
        initial: the initial state.
        plan: the plan.
        reached: function that tests whether a node of the search (a state and its path) reaches the goal.
        actions: operators that the plan must contain in order, as in `PlanningGoal`.
    """
    successors = SuccessorGenerator(domain, (), actions)
    start: PlanNode = SearchNode(initial)
    end = start
    for action in plan:
        end = successors.make_successor(end, action) or end
    if reached(end):
        return successors.remove_needless_actions(start, end, reached).list_actions()
    return tuple(plan)


class Planner:
    """Searches for plans in one domain.

    Args:
        domain: the domain.

    Attributes:
        domain: the domain.
        heuristic: the heuristic of the domain.
    """

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.heuristic = AdditiveHeuristic(domain)
        self._allowed: Callable[[State], bool] | None = None

    def restrict_states(self, allowed: Callable[[State], bool]) -> Planner:
        """Return a planner that shares the caches, but whose plans lead only through allowed states."""
        other = copy(self)
        other._allowed = allowed
        return other

    def holds(self, condition: Formula, state: State) -> bool:
        """Whether a closed condition holds in a state.

        The planner caches compiled conditions.
        """
        return self.heuristic.readings.holds(condition, {}, state)

    def looks_reachable(self, state: State, condition: Formula, objects: Sequence[int], **scope: int) -> bool:
        """Whether the heuristic finds actions on given objects that establish a condition.

        False is no proof that there are no such actions, but the planner does not search for such a
        condition. ``scope`` gives the objects of free variables.
        """
        estimates = CostEstimates(self.heuristic, state, objects)
        return estimates.estimate(Subgoal(condition, scope, True)) < INFINITE

    def find_plan(
        self, initial: State, goal: PlanningGoal, objects: Sequence[int], limits: Limits | None = None
    ) -> SearchResult[Action]:
        """Search for a plan.

        Args:
            initial: the initial state.
            goal: the goal.
            objects: the objects that actions may use, by index.
            limits: the limits of the search.
        """
        limits = limits or Limits()
        search = self._make_search(objects, goal.actions, limits)
        return _search_plan(search, SearchNode(initial), goal, limits)

    def find_actions_towards(
        self, initial: State, conditions: tuple[Subgoal, ...], objects: Sequence[int], limits: Limits
    ) -> tuple[Action, ...] | None:
        """Return actions that establish conditions together, by one greedy search; None if it fails.

        Args:
            initial: the initial state.
            conditions: the conditions.
            objects: the objects that actions may use, by index.
            limits: the limits of the search.
        """
        end = self._make_search(objects, (), limits).search(SearchNode(initial), conditions, 0, limits)
        return None if isinstance(end, SearchEndReason) else end.list_actions()

    def _make_search(
        self, objects: Sequence[int], actions: Sequence[Sequence[str]], limits: Limits
    ) -> GreedySearch:
        successors = SuccessorGenerator(self.domain, objects, actions, self._allowed)
        return GreedySearch(self.heuristic, successors, limits)


@lru_cache(maxsize=16)
def get_planner(domain: Domain) -> Planner:
    """Return the cached planner of a domain."""
    return Planner(domain)


def _search_plan(
    search: GreedySearch, start: PlanNode, goal: PlanningGoal, limits: Limits
) -> SearchResult[Action]:
    """Search until a plan is found, every kind of search has failed, or the limits are reached."""
    holds = search.heuristic.readings.holds

    def is_goal_reached_at_node(node: PlanNode) -> bool:
        return node.met == len(goal.actions) and all(holds(c, {}, node.state) for c in goal.conditions)

    goals = make_subgoals(goal.conditions, start.state.scene)
    agenda = _GoalAgenda(search, goals, start.state.scene)
    node, allowed, effort = start, _FIRST_LIMITS, search.effort
    while not is_goal_reached_at_node(node):
        further = None if search.is_over else agenda.reach_next_goal(node, allowed)
        if further is None and (search.is_over or not limits.thorough):
            return SearchResult(SearchEndReason.STATES, states=effort.used)
        if further is not None:
            node, allowed = further, _FIRST_LIMITS
        elif agenda.mark_newly_failed_goals_as_hard():
            node, allowed = start, _FIRST_LIMITS
        else:
            allowed = Limits(_LIMIT_GROWTH * allowed.states)
            end = search.search(start, goals, len(goal.actions), allowed)
            if end is SearchEndReason.UNREACHABLE:
                return SearchResult(end, states=effort.used)
            node = node if isinstance(end, SearchEndReason) else end
    last_node = search.successors.remove_needless_actions(start, node, is_goal_reached_at_node)
    return SearchResult(SearchEndReason.SOLVED, last_node.list_actions(), effort.used)


class _IsGoalUndone(NamedTuple):
    """Whether a goal is undone by actions for own objects, and by actions for foreign objects."""

    for_own_objects: bool
    for_foreign_objects: bool


class _ReasonableOrder:
    """The reasonable order of goals (Koehler and Hoffmann 2000).

    If a goal must be undone to reach another goal, the other goal comes first. The search learns the order
    from states in which one goal of a pair holds. Only literals with a common object are tested. All pairs
    with equal predicates, object categories and common arguments have the same order.

    Args:
        search: the searches and estimates.
        goals: closed conditions.
        scene: the objects.
    """

    def __init__(self, search: GreedySearch, goals: Sequence[Subgoal], scene: Scene) -> None:
        self._search = search
        self._goals = goals
        self._scene = scene
        self._literals = [self._make_literal(goal) for goal in goals]
        self._related_goals = self._list_goals_sharing_objects_by_goal()
        self._held: Set[int] = frozenset()
        self._must_precede: dict[tuple[object, ...], bool] = {}

    def _list_goals_sharing_objects_by_goal(self) -> list[list[int]]:
        """Return, for each goal, the indices of all goals with a common object."""
        goals_of_object = group_pairs(
            (index, i) for i, literal in enumerate(self._literals) for index in literal.arguments
        )
        return [
            list(dict.fromkeys([j for index in literal.arguments for j in goals_of_object[index]]))
            for literal in self._literals
        ]

    @property
    def has_ordered_goals(self) -> bool:
        """Whether any goal must come after another goal."""
        return any(self._must_precede.values())

    def find_goals_to_postpone(self, pending_goals: Sequence[int]) -> Set[int]:
        """Return the goals that must come after pending goals; no goals if the order is circular."""
        late = set[int]()
        waiting = [i for i in pending_goals if i != _NEXT_ACTION] if self.has_ordered_goals else []
        while waiting:
            earlier = waiting.pop()
            for later in self._related_goals[earlier]:
                if later not in late and self._must_precede.get(self._get_pair_key(earlier, later)):
                    late.add(later)
                    waiting.append(later)
        return set() if late.issuperset(pending_goals) else late

    def discard_learned_goal_order(self) -> None:
        """Give up the learned order of goals, because a goal that should come first seems unreachable."""
        self._must_precede = dict.fromkeys(self._must_precede, False)

    def learn_goal_order_from_node(
        self, node: PlanNode, estimates: CostEstimates, held_goals: Set[int]
    ) -> None:
        """Learn which goals must be reached before others, from a node in which the ``held_goals`` hold.

        Each goal that holds now, but did not hold at the last call, is compared with goals that do not hold.
        """
        for later in sorted(held_goals - self._held):
            for earlier in self._related_goals[later]:
                if earlier not in held_goals and self._get_pair_key(earlier, later) not in self._must_precede:
                    self._learn_order_of_goal_pair(node, estimates, earlier, later)
        self._held = held_goals

    def _make_literal(self, goal: Subgoal) -> GroundAtom:
        """Return a goal as a literal of a stored predicate.

        A goal that is no such literal becomes a literal without objects, so that its order is not learned.
        """
        formula, scope, truth = goal
        if not isinstance(formula, Atom) or formula.predicate in self._search.heuristic.derived:
            return GroundAtom("", (), truth)
        return GroundAtom(
            formula.predicate, find_object_indices_of_arguments(formula, scope, self._scene), truth
        )

    def _get_pair_key(self, earlier_goal: int, later_goal: int) -> tuple[object, ...]:
        pair = self._literals[earlier_goal], self._literals[later_goal]
        arguments = [index for literal in pair for index in literal.arguments]
        categories = [self._scene.objects[index].category for index in arguments]
        signature = [(literal.predicate, literal.truth) for literal in pair]
        return (*signature, *categories, *map(arguments.index, arguments))

    def _learn_order_of_goal_pair(
        self, node: PlanNode, estimates: CostEstimates, earlier: int, later: int
    ) -> None:
        """Find out whether goal ``earlier`` must be reached before ``later``, which holds in a node.

        It must be reached before if it seems unreachable while ``later`` is kept. The order stays unknown if
        ``earlier`` is too costly for a direct search. The learned order holds for all similar goals
        (`_get_pair_key`). So it also stays unknown if ``earlier`` seems reachable, but an action undoes
        ``later`` for foreign objects (`_check_if_goal_is_undone`).
        """
        goal = self._goals[earlier]
        if estimates.estimate(goal, _MAX_DIRECT_COST) == INFINITE:
            return
        own = self._literals[earlier].arguments
        undone = self._check_if_goal_is_undone(goal, own, self._goals[later], estimates)
        must_precede = False
        if undone.for_own_objects:
            kept = self._search.make_estimates(node, (self._goals[later],), forbid_undoing_protected=True)
            must_precede = kept.estimate(goal, _MAX_KEPT_COST) == INFINITE
        if must_precede or not undone.for_foreign_objects:
            self._must_precede[self._get_pair_key(earlier, later)] = must_precede

    def _check_if_goal_is_undone(
        self,
        condition: Subgoal,
        condition_objects: tuple[int, ...],
        kept_goal: Subgoal,
        estimates: CostEstimates,
    ) -> _IsGoalUndone:
        """Return whether actions on the cheapest estimated path to ``condition`` undo ``kept_goal``.

        An action serves the literal that it establishes, and the literals on the path from there to
        ``condition``. It serves a foreign object if such a literal has an object that is not in
        ``condition_objects``, but has the category of one. Otherwise it serves only the condition's objects.
        """
        heuristic, objects = self._search.heuristic, self._scene.objects
        own_categories = {objects[index].category for index in condition_objects}
        undoing = set[bool]()
        seen = set[tuple[GroundAtom, bool]]()
        waiting = [(condition, True)]
        while waiting:
            part, is_later_own = waiting.pop()
            for literal in estimates.split_into_cheapest_literal_subgoals(part):
                if not isinstance(literal.formula, Atom) or estimates.holds(literal):
                    continue
                atom = estimates.atom(literal.formula, literal)
                others = {
                    objects[index].category for index in atom.arguments if index not in condition_objects
                }
                is_own = is_later_own and others.isdisjoint(own_categories)
                if atom.predicate in heuristic.derived or (atom, is_own) in seen:
                    continue
                seen.add((atom, is_own))
                action, prerequisites = estimates.find_supporter(atom)[1:]
                if action is not None:
                    after = heuristic.domain.apply(estimates.state, action)
                    if heuristic.readings.holds(*kept_goal[:2], after) != kept_goal.truth:
                        undoing.add(is_own)
                waiting += [(prerequisite, is_own) for prerequisite in prerequisites]
        return _IsGoalUndone(True in undoing, False in undoing)


class _GoalAgenda:
    """Reaches the goals of one task one by one. Each search keeps the goals that were reached in order.

    Goals that can be reached in this way are called serialisable (Korf 1987). The goal with the lowest
    estimated cost comes first. If a goal is a disjunction, the parts of its cheapest disjunct are reached one
    by one. The disjunct is chosen again after every part.

    Args:
        search: the searches and estimates.
        goals: closed conditions.
        scene: the objects.
    """

    def __init__(self, search: GreedySearch, goals: Sequence[Subgoal], scene: Scene) -> None:
        self._search = search
        self._goals = goals
        self._order = _ReasonableOrder(search, goals, scene)
        self._undoing: set[int] = set()
        self._costs: dict[int, float] = {}
        self._hard: set[int] = set()
        self._failed: set[int] = set()

    def reach_next_goal(self, node: PlanNode, limits: Limits) -> PlanNode | None:
        """Return a node in which one more goal is reached; None if the search for each single goal fails."""
        estimates = self._search.make_estimates(node)
        held = {i for i, goal in enumerate(self._goals) if estimates.holds(goal)}
        pending = [i for i in range(len(self._goals)) if i not in held]
        self._order.learn_goal_order_from_node(node, estimates, held)
        late = self._order.find_goals_to_postpone(pending)
        reached = tuple([self._goals[i] for i in sorted(held - late)])
        if node.met < len(self._search.successors.goals):
            pending.append(_NEXT_ACTION)
        for i in self._generate_goals_by_cost(node, [i for i in pending if i not in late]):
            if i == _NEXT_ACTION:
                further = self._search_plan_for_subgoals(node, reached, node.met + 1, limits)
            else:
                protected = () if self._must_undo_reached_goals_for(node, i, reached) else reached
                further = self._reach_goal_by_parts(node, self._goals[i], protected, limits)
            if further is not None:
                return further
        self._failed = set(pending) - late
        self._order.discard_learned_goal_order()
        return None

    def mark_newly_failed_goals_as_hard(self) -> bool:
        """Mark the goals that the last searches failed to reach as hard, so that hard goals come first.

        Return False if all these goals were already marked.
        """
        new = self._failed - self._hard
        self._hard |= new
        return bool(new)

    def _must_undo_reached_goals_for(self, node: PlanNode, goal: int, reached: tuple[Subgoal, ...]) -> bool:
        """Whether a goal seems unreachable unless reached goals are undone. True at most once for each goal.

        So later searches for the goal protect the reached goals again. The result is False if no goal must
        come after another goal.
        """
        if not self._order.has_ordered_goals or goal in self._undoing:
            return False
        kept = self._search.make_estimates(node, reached, forbid_undoing_protected=True)
        if kept.estimate(self._goals[goal]) < INFINITE:
            return False
        self._undoing.add(goal)
        return True

    def _generate_goals_by_cost(self, node: PlanNode, pending: Sequence[int]) -> Iterator[int]:
        """Yield the indices of pending goals: hard goals first, then by estimated cost.

        Hard goals are goals that earlier searches failed to reach. Goals are first sorted by their costs from
        earlier calls. The cost of the first goal is then estimated for this node, which may move the goal
        back. A single pending goal is yielded without an estimate. If the caller asks for another goal, the
        cost of the single goal is estimated for later calls.
        """
        if len(pending) == 1:
            yield pending[0]
            self._estimate_cost(pending[0], node, self._search.make_estimates(node))
            return
        estimates = self._search.make_estimates(node)
        queue = [(i not in self._hard, self._costs.get(i, 0.0), i, False) for i in pending]
        heapq.heapify(queue)
        while queue:
            is_easy, _, i, is_estimated = heapq.heappop(queue)
            if is_estimated:
                yield i
                continue
            self._estimate_cost(i, node, estimates)
            heapq.heappush(queue, (is_easy, self._costs[i], i, True))

    def _estimate_cost(self, goal: int, node: PlanNode, estimates: CostEstimates) -> None:
        if goal == _NEXT_ACTION:
            self._costs[goal] = estimates.find_cheapest_action_of_operators(
                self._search.successors.goals[node.met]
            ).cost
        else:
            self._costs[goal] = estimates.estimate(self._goals[goal])

    def _reach_goal_by_parts(
        self, node: PlanNode, goal: Subgoal, protected: tuple[Subgoal, ...], limits: Limits
    ) -> PlanNode | None:
        """Reach the parts of a goal one after the other. If this fails, search for the whole goal."""
        while True:
            further = self._reach_one_more_part(node, goal, protected, limits)
            if further is None:
                whole_limits = replace(limits, states=_WHOLE_GOAL_FACTOR * limits.states)
                return self._search_plan_for_subgoals(node, (*protected, goal), node.met, whole_limits)
            node = further
            if self._search.make_estimates(node).estimate(goal) == 0.0:
                return node

    def _reach_one_more_part(
        self, node: PlanNode, goal: Subgoal, protected: tuple[Subgoal, ...], limits: Limits
    ) -> PlanNode | None:
        """Return a search node in which one more part of a goal is reached, or None if no part is reached.

        The parts are the literals that together establish the goal. They are tried by ascending cost. If the
        goal is a single literal of high estimated cost, the conditions that must hold before it are tried
        instead, by descending cost. If there are fewer than two parts or conditions, None is returned.
        """
        estimates = self._search.make_estimates(node, protected)
        parts: Sequence[Subgoal] = estimates.split_into_cheapest_literal_subgoals(goal)
        is_far = len(parts) < 2 and _MAX_DIRECT_COST < estimates.estimate(goal) < INFINITE
        if is_far:
            parts = estimates.find_prerequisites(goal)
        if len(parts) < 2:
            return None
        costs = [estimates.estimate(part) for part in parts]
        reached = (*protected, *[part for part, cost in zip(parts, costs, strict=True) if cost == 0.0])
        for i in sorted(range(len(parts)), key=lambda i: costs[i], reverse=is_far):
            further = None
            if costs[i] > _MAX_DIRECT_COST:
                further = self._reach_goal_by_parts(node, parts[i], reached, limits)
            elif costs[i] > 0.0:
                further = self._search_plan_for_subgoals(node, (*reached, parts[i]), node.met, limits)
            if further is not None:
                return further
        return None

    def _search_plan_for_subgoals(
        self, node: PlanNode, subgoals: tuple[Subgoal, ...], action_goal_count_to_reach: int, limits: Limits
    ) -> PlanNode | None:
        end = self._search.search(node, subgoals, action_goal_count_to_reach, limits)
        return None if isinstance(end, SearchEndReason) else end
