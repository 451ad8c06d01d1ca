"""Greedy best-first search: the state that looks nearest is expanded next.

It is expanded by its helpful actions (see `helpful`). If those lead nowhere, every possible action is
tried where that is asked for.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from typing import NamedTuple

from eai.planning.additive_heuristic import INFINITE, Distances, Regression
from eai.planning.preferred_operators import Helpful
from eai.planning.successor_generator import Moves, Node
from eai.planning.wanted import Wanted
from eai.world.execution import Action

_STEP_COST = 0.2
"""What a step of the way counts beside an estimated one of the way ahead: enough to leave long detours."""


class Target(NamedTuple):
    """What a search is for.

    Attributes:
        wanted: closed conditions that shall hold at the end.
        taken: how many of the action goals shall have been taken.
    """

    wanted: tuple[Wanted, ...]
    taken: int


class Effort(NamedTuple):
    """How much a search may do.

    Attributes:
        states: states that may be reached and estimated.
        complete: whether to try every possible action where the helpful ones lead nowhere.
    """

    states: int
    complete: bool


class Found(NamedTuple):
    """How a search ended.

    Attributes:
        node: where the target is reached, if it is.
        exhausted: whether nothing was left to expand.
    """

    node: Node | None
    exhausted: bool = False


class _Estimate(NamedTuple):
    cost: float
    helpful: tuple[Action, ...]


class BestFirst:
    """Searches in one domain, as long as there are states left to spend.

    Args:
        regression: estimates with.
        moves: moves by.
        states: states that all searches together may reach and estimate.

    Attributes:
        states: how many of them are left.
    """

    def __init__(self, regression: Regression, moves: Moves, states: int) -> None:
        self._regression = regression
        self._moves = moves
        self.states = states

    def search(self, start: Node, target: Target, effort: Effort) -> Found:
        """Look for a way from a node to a target."""
        if self.states <= 0:
            return Found(None)
        affordable = effort._replace(states=min(effort.states, self.states))
        run = _Run(self._regression, self._moves, start, target, affordable)
        found = run.run()
        self.states -= run.states
        return found


class _Run:
    """The state of one search."""

    def __init__(
        self, regression: Regression, moves: Moves, start: Node, target: Target, effort: Effort
    ) -> None:
        self._regression = regression
        self._moves = moves
        self._start = start
        self._target = target
        self._effort = effort
        self._seen = {(start.state, start.taken)}
        self._queue: list[tuple[float, int, Node, tuple[Action, ...]]] = []
        self._later: list[tuple[float, int, Node]] = []
        self.states = 0

    def run(self) -> Found:
        found = self._reach(self._start)
        while found is None:
            if self.states >= self._effort.states:
                return Found(None)
            step = self._next()
            if step is None:
                return Found(None, exhausted=True)
            found = self._expand(*step)
        return Found(found)

    def _next(self) -> tuple[Node, Sequence[Action]] | None:
        """What to expand next: a state by its helpful actions, or else an expanded one by all others."""
        if self._queue:
            rank, number, node, helpful = heapq.heappop(self._queue)
            heapq.heappush(self._later, (rank, number, node))
            return node, helpful
        if self._later and self._effort.complete:
            _, _, node = heapq.heappop(self._later)
            return node, tuple(self._moves.possible(node))
        return None

    def _expand(self, node: Node, actions: Sequence[Action]) -> Node | None:
        for action in actions:
            if self.states >= self._effort.states:
                return None
            after = self._moves.after(node, action)
            if after is None or (after.state, after.taken) in self._seen:
                continue
            self._seen.add((after.state, after.taken))
            found = self._reach(after)
            if found is not None:
                return found
        return None

    def _reach(self, node: Node) -> Node | None:
        """Estimate a state that was reached and queue it; the node itself if the target is reached in it."""
        self.states += 1
        estimate = self._estimate(node)
        if estimate.cost == 0.0:
            return node
        rank = estimate.cost + _STEP_COST * (node.depth - self._start.depth)
        heapq.heappush(self._queue, (rank, -self.states, node, estimate.helpful))
        return None

    def _estimate(self, node: Node) -> _Estimate:
        wanted, taken = self._target
        distances = Distances(self._regression, node.state, self._moves.objects, wanted)
        helpful = Helpful(self._regression, distances)
        total = 0.0
        for condition in wanted:
            cost = distances.to(condition)
            total += cost
            if 0.0 < cost < INFINITE:
                helpful.towards(condition)
        for names in self._moves.goals[node.taken : taken]:
            way = distances.to_action(names)
            total += way.cost
            helpful.along(way)
        return _Estimate(total, tuple(helpful.actions))
