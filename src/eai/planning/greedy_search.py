"""Greedy best-first search: the state with the lowest estimated cost is expanded next.

A state is expanded by its preferred operators (Hoffmann and Nebel 2001): the applicable actions on the
cheapest estimated path to a condition (see `additive_heuristic`). If these actions lead to no goal, a
thorough search (`Limits.thorough`) tries every applicable action. A search that is not thorough returns only
to dead ends: states whose preferred operators all lead to known states. It estimates such a state again,
without these operators, so that other operators are preferred.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from typing import NamedTuple

from eai.logic.formula import Atom
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, CostEstimates
from eai.planning.search import Limits, OpenList, SearchEffort, SearchEndReason, run_best_first_search
from eai.planning.subgoal import GroundAtom, Subgoal
from eai.planning.successor_generator import (
    PlanNode,
    SuccessorGenerator,
    generate_applicable_actions_of_operator,
)
from eai.world.action import Action
from eai.world.derived import DefinedPredicate

_STEP_COST = 0.2
"""Cost of each action on the path so far, just high enough that the search gives up long detours.

Each action that is estimated to follow costs 1.
"""

_UNEXPANDED, _EXPANDED = 0, 1
"""Ranks of states in the queue: states that are not expanded yet come first."""


class GreedySearch:
    """Greedy searches in one domain, with common limits.

    Args:
        heuristic: the heuristic of the domain.
        successors: the generator of the states after one action.
        limits: the limits of all searches together.

    Attributes:
        heuristic: the heuristic of the domain.
        successors: the generator of the states after one action.
        effort: counter of states that were reached and estimated.
        bindings: counter of the parameter values that were tried to find actions.
    """

    def __init__(self, heuristic: AdditiveHeuristic, successors: SuccessorGenerator, limits: Limits) -> None:
        self.heuristic = heuristic
        self.successors = successors
        self.effort = SearchEffort(limits.states)
        self.bindings = SearchEffort(limits.bindings)
        self._looks = SearchEffort(limits.looks)
        self._last: CostEstimates | None = None

    @property
    def is_over(self) -> bool:
        """Whether all searches together have reached a limit."""
        return (
            self.effort.is_limit_reached or self._looks.is_limit_exceeded or self.bindings.is_limit_exceeded
        )

    def make_estimates(
        self,
        node: PlanNode,
        protected_subgoals: Sequence[Subgoal] = (),
        *,
        forbid_undoing_protected: bool = False,
        excluded: Set[Action] = frozenset(),
    ) -> CostEstimates:
        """Return cost estimates from a node's state.

        Actions that make a condition in ``protected_subgoals`` false cost more. If
        ``forbid_undoing_protected`` is true, they are left out. Actions in ``excluded`` are always left out.
        """
        objects = self.successors.objects
        self._last = CostEstimates(
            self.heuristic,
            node.state,
            objects,
            protected_subgoals,
            self._looks,
            self.bindings,
            self._last,
            forbid_undoing_protected=forbid_undoing_protected,
            excluded=excluded,
        )
        return self._last

    def search(
        self, start: PlanNode, subgoals: tuple[Subgoal, ...], action_goal_count_to_reach: int, limits: Limits
    ) -> PlanNode | SearchEndReason:
        """Search for a path from a node to a target. If no path is found, return how the search ended.

        Args:
            start: the node.
            subgoals: closed conditions that must hold at the end.
            action_goal_count_to_reach: number of action goals (operators to take, in order) that must be
                taken at the end.
            limits: the limits. If `Limits.thorough` is set, all applicable actions are tried after the
                preferred actions.
        """
        if self.is_over:
            return SearchEndReason.STATES
        effort = SearchEffort(min(limits.states, self.effort.limit - self.effort.used))
        end = _GreedySearchRun(
            self, start, (subgoals, action_goal_count_to_reach), effort, thorough=limits.thorough
        ).search()
        self.effort.used += effort.used
        return end

    def estimate_cost_and_preferred_actions(
        self,
        node: PlanNode,
        subgoals: tuple[Subgoal, ...],
        action_goal_count_to_reach: int,
        excluded: Set[Action] = frozenset(),
    ) -> tuple[float, tuple[Action, ...]]:
        """Return the estimated cost from a node to a target, and the preferred actions of the node's state.

        Args:
            node: the node.
            subgoals: closed conditions that the target meets.
            action_goal_count_to_reach: number of action goals (operators to take, in order) that are taken at
                the target.
            excluded: actions that the estimates leave out.
        """
        estimates = self.make_estimates(node, subgoals, excluded=excluded)
        preferred = _PreferredActionCollector(self.heuristic, estimates)
        total = 0.0
        for condition in subgoals:
            cost = estimates.estimate(condition)
            total += cost
            if 0.0 < cost < INFINITE:
                preferred.collect_actions_towards(condition)
        for names in self.successors.goals[node.met : action_goal_count_to_reach]:
            supporter = estimates.find_cheapest_action_of_operators(names)
            total += supporter.cost
            preferred.collect_action_or_actions_for_prerequisites(supporter.action, supporter.prerequisites)
        return total, tuple(preferred.actions)


class _NodeWithActionsToTry(NamedTuple):
    """A node to expand, its rank, and the actions to try from it.

    The actions are None if the node was expanded before. Then a thorough search tries all applicable actions.
    A search that is not thorough estimates the node's cost again, and leaves out the actions in ``excluded``.
    """

    node: PlanNode
    rank: tuple[float, int]
    actions: tuple[Action, ...] | None
    excluded: frozenset[Action]


class _GreedySearchRun:
    """One greedy search."""

    def __init__(
        self,
        searches: GreedySearch,
        start: PlanNode,
        target: tuple[tuple[Subgoal, ...], int],
        effort: SearchEffort,
        *,
        thorough: bool,
    ) -> None:
        self._searches = searches
        self._successors = searches.successors
        self._start = start
        self._target = target
        self._effort = effort
        self._thorough = thorough
        self._seen = {(start.state, start.met)}
        self._open: OpenList[_NodeWithActionsToTry] = OpenList()

    def search(self) -> PlanNode | SearchEndReason:
        """Search for a path from the start to the target."""
        return self._return_target_or_queue_node(self._start) or run_best_first_search(
            self._open.pop, self._expand_state
        )

    def _expand_state(self, expansion: _NodeWithActionsToTry) -> PlanNode | SearchEndReason | None:
        """Expand a state by its preferred actions: applicable actions on cheapest estimated paths.

        A thorough search later expands the state by all other actions. A search that is not thorough returns
        to the state only if all preferred actions lead to known states.
        """
        node, rank, actions, excluded = expansion
        if actions is None and not self._thorough:
            return self._return_target_or_queue_node(node, excluded)
        is_dead_end = bool(actions)  # `excluded` contains no preferred action
        applicable = self._successors.generate_applicable_actions(node, self._searches.bindings)
        for action in applicable if actions is None else actions:
            if self._is_over:
                break
            after = self._successors.make_successor(node, action)
            if after is None or (after.state, after.met) in self._seen:
                continue
            is_dead_end = False
            self._seen.add((after.state, after.met))
            goal = self._return_target_or_queue_node(after)
            if goal is not None:
                return goal
        if actions is not None and (is_dead_end or self._thorough):
            self._open.push(
                _NodeWithActionsToTry(node, rank, None, excluded.union(actions)), _EXPANDED, *rank
            )
        return SearchEndReason.STATES if self._is_over else None

    @property
    def _is_over(self) -> bool:
        return self._effort.is_limit_reached or self._searches.is_over

    def _return_target_or_queue_node(
        self, node: PlanNode, excluded: frozenset[Action] = frozenset()
    ) -> PlanNode | None:
        """Queue a node by its estimated cost. If it reaches the target of the search, return it instead.

        The estimate leaves out the actions in ``excluded``.
        """
        self._effort.used += 1
        ahead, preferred = self._searches.estimate_cost_and_preferred_actions(node, *self._target, excluded)
        if ahead == 0.0:
            return node
        cost = ahead + _STEP_COST * (node.depth - self._start.depth)
        rank = (cost, -self._effort.used)
        self._open.push(_NodeWithActionsToTry(node, rank, preferred, excluded), _UNEXPANDED, *rank)
        return None


class _PreferredActionCollector:
    """Collects the preferred actions of one state: applicable actions on cheapest estimated paths.

    Args:
        heuristic: the heuristic of the domain.
        estimates: the estimated costs of conditions from the state.

    Attributes:
        actions: the collected actions, each once, in order.
    """

    def __init__(self, heuristic: AdditiveHeuristic, estimates: CostEstimates) -> None:
        self._heuristic = heuristic
        self._estimates = estimates
        self._seen: set[GroundAtom] = set()
        self.actions: dict[Action, None] = {}

    def collect_actions_towards(self, goal: Subgoal) -> None:
        """Collect the applicable actions on the cheapest path to a goal.

        If the goal is a disjunction, collect the actions for each disjunct of lowest cost.
        """
        alternatives = self._estimates.find_cheapest_disjuncts(goal)
        for condition in alternatives:
            self.collect_actions_towards(condition)
        if not alternatives:
            self._collect_preferred_actions(goal)

    def collect_action_or_actions_for_prerequisites(
        self, action: Action | None, prerequisites: Sequence[Subgoal]
    ) -> None:
        """Collect an action if it has no prerequisites, else the applicable actions that lead to them."""
        if action is not None and not prerequisites:
            self.actions[action] = None
        for condition in prerequisites:
            self._collect_preferred_actions(condition)

    def _collect_preferred_actions(self, subgoal: Subgoal) -> None:
        if self._estimates.holds(subgoal):
            return
        if isinstance(subgoal.formula, Atom):
            atom = self._estimates.atom(subgoal.formula, subgoal)
            if atom in self._seen:
                return
            self._seen.add(atom)
            derived = self._heuristic.derived.get(atom.predicate)
            if derived is None:
                supporter = self._estimates.find_supporter(atom)
                self.collect_action_or_actions_for_prerequisites(supporter.action, supporter.prerequisites)
                return
            if not isinstance(derived, DefinedPredicate):
                self.actions.update((action, None) for action in self._find_actions_changing(derived.reads))
        for part in self._estimates.split_into_cheapest_sufficient_parts(subgoal) or ():
            self._collect_preferred_actions(part)

    def _find_actions_changing(self, predicates: tuple[str, ...]) -> Iterator[Action]:
        for operator in self._heuristic.achievers.find_changing_operators(predicates):
            yield from generate_applicable_actions_of_operator(
                self._heuristic.domain,
                operator,
                self._estimates.state,
                self._estimates.objects,
                self._estimates.bindings,
            )
