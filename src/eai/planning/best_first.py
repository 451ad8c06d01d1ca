"""Greedy best-first search: the state that looks nearest is expanded next.

It is expanded by its preferred actions (see `preferred_operators`). If those lead nowhere, every applicable
action is tried where that is asked for.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import NamedTuple

from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, Estimates
from eai.planning.effort import Effort
from eai.planning.preferred_operators import PreferredOperators
from eai.planning.subgoal import Subgoal
from eai.planning.successor_generator import Node, SuccessorGenerator
from eai.world.execution import Action

_STEP_COST = 0.2
"""What a step of the way counts beside an estimated one of the way ahead: enough to leave long detours."""


class Target(NamedTuple):
    """What a search is for.

    Attributes:
        subgoals: closed conditions that shall hold at the end.
        taken: how many of the action goals shall have been taken.
    """

    subgoals: tuple[Subgoal, ...]
    taken: int


class Budget(NamedTuple):
    """How much a search may do.

    Attributes:
        states: states that may be reached and estimated.
        complete: whether to try every applicable action where the preferred ones lead nowhere.
    """

    states: int
    complete: bool


class SearchOutcome(NamedTuple):
    """How a search ended.

    Attributes:
        node: where the target is reached, if it is.
        exhausted: whether nothing was left to expand.
    """

    node: Node | None
    exhausted: bool = False


class _Estimate(NamedTuple):
    cost: float
    preferred: tuple[Action, ...]


class BestFirst:
    """Searches in one domain, as long as there are states left to spend.

    Args:
        heuristic: estimates with.
        successors: gives the states one action further.
        states: states that all searches together may reach and estimate.

    Attributes:
        effort: how many were reached and estimated.
    """

    def __init__(self, heuristic: AdditiveHeuristic, successors: SuccessorGenerator, states: int) -> None:
        self._heuristic = heuristic
        self._successors = successors
        self.effort = Effort(states)

    def search(self, start: Node, target: Target, budget: Budget) -> SearchOutcome:
        """Look for a way from a node to a target."""
        if self.effort.is_used_up:
            return SearchOutcome(None)
        affordable = Effort(min(budget.states, self.effort.limit - self.effort.used))
        run = _BestFirstRun(
            self._heuristic, self._successors, start, target, affordable, complete=budget.complete
        )
        found = run.run()
        self.effort.used += affordable.used
        return found


class _BestFirstRun:
    """The state of one search."""

    def __init__(
        self,
        heuristic: AdditiveHeuristic,
        successors: SuccessorGenerator,
        start: Node,
        target: Target,
        effort: Effort,
        *,
        complete: bool,
    ) -> None:
        self._heuristic = heuristic
        self._successors = successors
        self._start = start
        self._target = target
        self._effort = effort
        self._complete = complete
        self._seen = {(start.state, start.taken)}
        self._queue: list[tuple[float, int, Node, tuple[Action, ...]]] = []
        self._later: list[tuple[float, int, Node]] = []

    def run(self) -> SearchOutcome:
        found = self._reach(self._start)
        while found is None:
            if self._effort.is_used_up:
                return SearchOutcome(None)
            step = self._next()
            if step is None:
                return SearchOutcome(None, exhausted=True)
            found = self._expand(*step)
        return SearchOutcome(found)

    def _next(self) -> tuple[Node, Sequence[Action]] | None:
        """What to expand next: a state by its preferred actions, or else an expanded one by all others."""
        if self._queue:
            rank, number, node, preferred = heapq.heappop(self._queue)
            heapq.heappush(self._later, (rank, number, node))
            return node, preferred
        if self._later and self._complete:
            _, _, node = heapq.heappop(self._later)
            return node, tuple(self._successors.applicable(node))
        return None

    def _expand(self, node: Node, actions: Sequence[Action]) -> Node | None:
        for action in actions:
            if self._effort.is_used_up:
                return None
            after = self._successors.successor(node, action)
            if after is None or (after.state, after.taken) in self._seen:
                continue
            self._seen.add((after.state, after.taken))
            found = self._reach(after)
            if found is not None:
                return found
        return None

    def _reach(self, node: Node) -> Node | None:
        """Estimate a state that was reached and queue it; the node itself if the target is reached in it."""
        self._effort.used += 1
        estimate = self._estimate(node)
        if estimate.cost == 0.0:
            return node
        rank = estimate.cost + _STEP_COST * (node.depth - self._start.depth)
        heapq.heappush(self._queue, (rank, -self._effort.used, node, estimate.preferred))
        return None

    def _estimate(self, node: Node) -> _Estimate:
        subgoals, taken = self._target
        estimates = Estimates(self._heuristic, node.state, self._successors.objects, subgoals)
        preferred = PreferredOperators(self._heuristic, estimates)
        total = 0.0
        for condition in subgoals:
            cost = estimates.to(condition)
            total += cost
            if 0.0 < cost < INFINITE:
                preferred.towards(condition)
        for names in self._successors.goals[node.taken : taken]:
            supporter = estimates.to_action(names)
            total += supporter.cost
            preferred.along(supporter)
        return _Estimate(total, tuple(preferred.actions))
