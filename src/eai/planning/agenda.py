"""One goal after the other: each is reached by a search of its own that ends with all reached before intact.

Goals that can be put in such an order are called serialisable (Korf 1987). The one that looks nearest comes
first; one with alternatives is reached part by part along the cheapest of them, which is chosen anew after
every part.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

from eai.planning.additive_heuristic import AdditiveHeuristic, Estimates
from eai.planning.best_first import BestFirst, Budget, Target
from eai.planning.subgoal import Subgoal
from eai.planning.successor_generator import Node, SuccessorGenerator

_WHOLE = 4
"""How many times the budget for a part may be spent on a goal as a whole."""

_NEXT_ACTION = -1
"""The number of the goal to take the next action; conditions are numbered from 0."""


class Agenda:
    """Reaches the goals of one task one by one.

    Args:
        heuristic: estimates with.
        successors: gives the states one action further.
        search: searches with.
        goals: closed conditions.
    """

    def __init__(
        self,
        heuristic: AdditiveHeuristic,
        successors: SuccessorGenerator,
        search: BestFirst,
        goals: Sequence[Subgoal],
    ) -> None:
        self._heuristic = heuristic
        self._successors = successors
        self._goals = goals
        self._search = search
        self._costs: dict[int, float] = {}
        self._hard: set[int] = set()
        self._failed: set[int] = set()

    def advance(self, node: Node, budget: Budget) -> Node | None:
        """The node in which one goal more is reached, or None if this budget reaches none."""
        holds = self._estimates(node).holds
        kept = tuple([goal for goal in self._goals if holds(goal)])
        pending = [i for i, goal in enumerate(self._goals) if not holds(goal)]
        if node.taken < len(self._successors.goals):
            pending.append(_NEXT_ACTION)
        for i in self._nearest_first(node, pending):
            if i == _NEXT_ACTION:
                found = self._reach(node, Target(kept, node.taken + 1), budget)
            else:
                found = self._achieve(node, self._goals[i], kept, budget)
            if found is not None:
                return found
        self._failed = set(pending)
        return None

    def learn(self) -> bool:
        """Put what was not reached in the end before everything else, if that is new; to begin again with."""
        new = self._failed - self._hard
        self._hard |= new
        return bool(new)

    def _nearest_first(self, node: Node, pending: Sequence[int]) -> Iterator[int]:
        """Goals by their cost, the hard ones before the others.

        What a goal cost when last looked at stands until its turn comes; only then is it looked at again. The
        only one is looked at where it is not reached: that says when its turn comes after a new beginning.
        """
        if len(pending) == 1:
            yield pending[0]
            self._look_at(pending[0], node, self._estimates(node))
            return
        estimates = self._estimates(node)
        queue = [(i not in self._hard, self._costs.get(i, 0.0), i, False) for i in pending]
        heapq.heapify(queue)
        while queue:
            is_easy, _, i, is_looked_at = heapq.heappop(queue)
            if is_looked_at:
                yield i
                continue
            self._look_at(i, node, estimates)
            heapq.heappush(queue, (is_easy, self._costs[i], i, True))

    def _look_at(self, i: int, node: Node, estimates: Estimates) -> None:
        """Estimate what a goal costs."""
        if i == _NEXT_ACTION:
            self._costs[i] = estimates.to_action(self._successors.goals[node.taken]).cost
        else:
            self._costs[i] = estimates.to(self._goals[i])

    def _achieve(self, node: Node, goal: Subgoal, kept: tuple[Subgoal, ...], budget: Budget) -> Node | None:
        """Reach a goal part by part, or else as a whole."""
        while True:
            part = self._next_part(node, goal, kept, budget)
            if part is None:
                whole = budget._replace(states=_WHOLE * budget.states)
                return self._reach(node, Target((*kept, goal), node.taken), whole)
            node = part
            if self._estimates(node).to(goal) == 0.0:
                return node

    def _next_part(self, node: Node, goal: Subgoal, kept: tuple[Subgoal, ...], budget: Budget) -> Node | None:
        estimates = self._estimates(node, kept)
        parts = estimates.chosen(goal)
        if len(parts) < 2:
            return None
        costs = [estimates.to(part) for part in parts]
        held = tuple([part for part, cost in zip(parts, costs, strict=True) if cost == 0.0])
        for i in sorted(range(len(parts)), key=lambda i: costs[i]):
            if costs[i] > 0.0:
                found = self._reach(node, Target((*kept, *held, parts[i]), node.taken), budget)
                if found is not None:
                    return found
        return None

    def _reach(self, node: Node, target: Target, budget: Budget) -> Node | None:
        return self._search.search(node, target, budget).node

    def _estimates(self, node: Node, kept: Sequence[Subgoal] = ()) -> Estimates:
        return Estimates(self._heuristic, node.state, self._successors.objects, kept)
