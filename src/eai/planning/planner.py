"""Planning by search on a declared domain: a plan that takes some actions in order and makes conditions hold.

The goals are reached one after the other, each by greedy best-first search (`greedy_search`) that is guided
by the additive heuristic, computed backwards from the goal (`additive_heuristic`). Where no goal can be
reached without giving up another one, all are searched for together. All actions of a plan are applicable.
Effort is bounded by a number of states, never by time: equal input gives equal output.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import lru_cache

from eai.logic.formula import Formula
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, Estimates
from eai.planning.greedy_search import GreedySearch
from eai.planning.search import Limits, Node, SearchEnd, SearchResult
from eai.planning.subgoal import Subgoal, subgoals_of
from eai.planning.successor_generator import PlanNode, SuccessorGenerator
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.state import State

_FIRST = Limits(50, thorough=False)
"""The limits of reaching one goal, at first."""

_MORE = 4
"""How many times as much is spent after all have failed."""

_WHOLE = 4
"""How many times what is spent on a part may be spent on a goal as a whole."""

_FAR = 12.0
"""How far a single goal may be that is reached at once; what a farther one needs first is reached before."""

_NEXT_ACTION = -1
"""The number of the goal to take the next action; conditions are numbered from 0."""


@dataclass(frozen=True, slots=True)
class PlanningGoal:
    """The goal of a plan.

    Attributes:
        conditions: closed state formulas that shall hold at the end.
        actions: operators to be taken, one after the other, with whatever objects; each entry lists
            alternatives.
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
    """The actions of a plan that it needs to end as it must; all of them if it does not end so.

    Args:
        domain: the domain.
        initial: the state to start from.
        plan: the plan.
        reached: whether it ends as it must.
        actions: operators to be taken, as in `PlanningGoal`.
    """
    successors = SuccessorGenerator(domain, (), actions)
    start: PlanNode = Node(initial)
    end = start
    for action in plan:
        end = successors.successor(end, action) or end
    return successors.remove_needless_actions(start, end, reached).plan() if reached(end) else tuple(plan)


class Planner:
    """Searches for plans in one domain.

    Args:
        domain: the domain.

    Attributes:
        domain: the domain.
        heuristic: guides it.
    """

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        self.heuristic = AdditiveHeuristic(domain)
        self._allowed: Callable[[State], bool] | None = None

    def restrict_states(self, allowed: Callable[[State], bool]) -> Planner:
        """The planner whose plans lead through some states only, which knows what this one does."""
        other = copy(self)
        other._allowed = allowed
        return other

    def holds(self, condition: Formula, state: State) -> bool:
        """Whether a closed condition holds in a state. It is read once, and kept as long as the planner."""
        return self.heuristic.readings.holds(condition, {}, state)

    def looks_reachable(self, state: State, condition: Formula, objects: Sequence[int], **scope: int) -> bool:
        """Whether a condition may be brought about by actions on some objects, at first sight.

        That it looks out of reach is no proof that it is; but no search is spent on it. ``scope`` gives its
        free variables their objects.
        """
        estimates = Estimates(self.heuristic, state, objects)
        return estimates.estimate(Subgoal(condition, scope, True)) < INFINITE

    def plan(
        self,
        initial: State,
        goal: PlanningGoal,
        objects: Sequence[int],
        limits: Limits | None = None,
    ) -> SearchResult[Action]:
        """Look for a plan.

        Args:
            initial: the state to start from.
            goal: what to achieve.
            objects: what actions may be about, by index.
            limits: how much to do.
        """
        limits = limits or Limits()
        search = self._search(objects, goal.actions, limits)
        return _found(search, Node(initial), goal, limits)

    def reach(
        self, initial: State, conditions: tuple[Subgoal, ...], objects: Sequence[int], limits: Limits
    ) -> tuple[Action, ...] | None:
        """The actions by which one greedy search brings conditions about together, if it does.

        Args:
            initial: the state to start from.
            conditions: the conditions.
            objects: what actions may be about, by index.
            limits: how much to do.
        """
        found = self._search(objects, (), limits).search(Node(initial), conditions, 0, limits)
        return None if isinstance(found, SearchEnd) else found.plan()

    def _search(
        self, objects: Sequence[int], actions: Sequence[Sequence[str]], limits: Limits
    ) -> GreedySearch:
        successors = SuccessorGenerator(self.domain, objects, actions, self._allowed)
        return GreedySearch(self.heuristic, successors, limits)


@lru_cache(maxsize=16)
def get_planner(domain: Domain) -> Planner:
    """The planner of a domain, made once."""
    return Planner(domain)


def _found(search: GreedySearch, start: PlanNode, goal: PlanningGoal, limits: Limits) -> SearchResult[Action]:
    """Search until there is a plan, nothing is left, or the limits are reached."""
    holds = search.heuristic.readings.holds

    def is_reached(node: PlanNode) -> bool:
        return node.met == len(goal.actions) and all(holds(c, {}, node.state) for c in goal.conditions)

    goals = subgoals_of(goal.conditions, start.state.scene)
    agenda = _Agenda(search, goals)
    node, allowed, effort = start, _FIRST, search.effort
    while not is_reached(node):
        further = agenda.advance(node, allowed)
        if search.is_over or (further is None and not limits.thorough):
            return SearchResult(SearchEnd.STATES, states=effort.used)
        if further is not None:
            node, allowed = further, _FIRST
        elif agenda.learn():
            node, allowed = start, _FIRST
        else:
            allowed = Limits(_MORE * allowed.states)
            found = search.search(start, goals, len(goal.actions), allowed)
            if found is SearchEnd.UNREACHABLE:
                return SearchResult(found, states=effort.used)
            node = node if isinstance(found, SearchEnd) else found
    end = search.successors.remove_needless_actions(start, node, is_reached)
    return SearchResult(SearchEnd.SOLVED, end.plan(), effort.used)


class _Agenda:
    """Reaches the goals of one task one by one, each by a search that ends with all reached before intact.

    Goals that can be put in such an order are called serialisable (Korf 1987). The one that looks nearest
    comes first; one with alternatives is reached part by part along the cheapest of them, which is chosen
    anew after every part.

    Args:
        search: searches and estimates with.
        goals: closed conditions.
    """

    def __init__(self, search: GreedySearch, goals: Sequence[Subgoal]) -> None:
        self._search = search
        self._goals = goals
        self._costs: dict[int, float] = {}
        self._hard: set[int] = set()
        self._failed: set[int] = set()

    def advance(self, node: PlanNode, limits: Limits) -> PlanNode | None:
        """The node in which one goal more is reached, or None if none is reached within the limits."""
        holds = self._search.estimates(node).holds
        kept = tuple([goal for goal in self._goals if holds(goal)])
        pending = [i for i, goal in enumerate(self._goals) if not holds(goal)]
        if node.met < len(self._search.successors.goals):
            pending.append(_NEXT_ACTION)
        for i in self._nearest_first(node, pending):
            if i == _NEXT_ACTION:
                found = self._reach(node, kept, node.met + 1, limits)
            else:
                found = self._achieve(node, self._goals[i], kept, limits)
            if found is not None:
                return found
        self._failed = set(pending)
        return None

    def learn(self) -> bool:
        """Put what was not reached in the end before everything else, if that is new; to begin again with."""
        new = self._failed - self._hard
        self._hard |= new
        return bool(new)

    def _nearest_first(self, node: PlanNode, pending: Sequence[int]) -> Iterator[int]:
        """Goals by their cost, the hard ones before the others.

        What a goal cost when last looked at stands until its turn comes; only then is it looked at again. The
        only one is looked at where it is not reached: that says when its turn comes after a new beginning.
        """
        if len(pending) == 1:
            yield pending[0]
            self._look_at(pending[0], node, self._search.estimates(node))
            return
        estimates = self._search.estimates(node)
        queue = [(i not in self._hard, self._costs.get(i, 0.0), i, False) for i in pending]
        heapq.heapify(queue)
        while queue:
            is_easy, _, i, is_looked_at = heapq.heappop(queue)
            if is_looked_at:
                yield i
                continue
            self._look_at(i, node, estimates)
            heapq.heappush(queue, (is_easy, self._costs[i], i, True))

    def _look_at(self, i: int, node: PlanNode, estimates: Estimates) -> None:
        """Estimate what a goal costs."""
        if i == _NEXT_ACTION:
            self._costs[i] = estimates.estimate_action(self._search.successors.goals[node.met]).cost
        else:
            self._costs[i] = estimates.estimate(self._goals[i])

    def _achieve(
        self, node: PlanNode, goal: Subgoal, kept: tuple[Subgoal, ...], limits: Limits
    ) -> PlanNode | None:
        """Reach a goal part by part, or else as a whole."""
        while True:
            part = self._next_part(node, goal, kept, limits)
            if part is None:
                whole = replace(limits, states=_WHOLE * limits.states)
                return self._reach(node, (*kept, goal), node.met, whole)
            node = part
            if self._search.estimates(node).estimate(goal) == 0.0:
                return node

    def _next_part(
        self, node: PlanNode, goal: Subgoal, kept: tuple[Subgoal, ...], limits: Limits
    ) -> PlanNode | None:
        """The node in which one part more is reached, or None where there are none or none is reached.

        The nearest comes first; of what a far goal needs the farthest.
        """
        estimates = self._search.estimates(node, kept)
        parts: Sequence[Subgoal] = estimates.choose_atoms(goal)
        is_far = len(parts) < 2 and _FAR < estimates.estimate(goal) < INFINITE
        if is_far:
            parts = estimates.find_prerequisites(goal)
        if len(parts) < 2:
            return None
        costs = [estimates.estimate(part) for part in parts]
        held = (*kept, *[part for part, cost in zip(parts, costs, strict=True) if cost == 0.0])
        for i in sorted(range(len(parts)), key=lambda i: costs[i], reverse=is_far):
            found = None
            if costs[i] > _FAR:
                found = self._achieve(node, parts[i], held, limits)
            elif costs[i] > 0.0:
                found = self._reach(node, (*held, parts[i]), node.met, limits)
            if found is not None:
                return found
        return None

    def _reach(
        self, node: PlanNode, subgoals: tuple[Subgoal, ...], taken: int, limits: Limits
    ) -> PlanNode | None:
        found = self._search.search(node, subgoals, taken, limits)
        return None if isinstance(found, SearchEnd) else found
