"""One goal after the other: each is reached by a search of its own that ends with all reached before intact.

Goals that can be put in such an order are called serialisable (Korf 1987). The one that looks nearest comes
first; one with alternatives is reached part by part along the cheapest of them, which is chosen anew after
every part.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence

from eai.planning.additive_heuristic import Distances, Regression
from eai.planning.best_first import BestFirst, Effort, Target
from eai.planning.successor_generator import Moves, Node
from eai.planning.wanted import Wanted

_WHOLE = 4
"""How many times the effort for a part may be spent on a goal as a whole."""

_NEXT_ACTION = -1
"""The number of the goal to take the next action; conditions are numbered from 0."""


class Agenda:
    """Reaches the goals of one task one by one.

    Args:
        regression: estimates with.
        moves: moves by.
        search: searches with.
        goals: closed conditions.
    """

    def __init__(
        self, regression: Regression, moves: Moves, search: BestFirst, goals: Sequence[Wanted]
    ) -> None:
        self._regression = regression
        self._moves = moves
        self._goals = goals
        self._search = search
        self._costs: dict[int, float] = {}
        self._hard: set[int] = set()
        self._failed: set[int] = set()

    def advance(self, node: Node, effort: Effort) -> Node | None:
        """The node in which one goal more is reached, or None if this effort reaches none."""
        holds = self._distances(node).holds
        kept = tuple([goal for goal in self._goals if holds(goal)])
        pending = [i for i, goal in enumerate(self._goals) if not holds(goal)]
        if node.taken < len(self._moves.goals):
            pending.append(_NEXT_ACTION)
        for i in self._nearest_first(node, pending):
            if i == _NEXT_ACTION:
                found = self._reach(node, Target(kept, node.taken + 1), effort)
            else:
                found = self._achieve(node, self._goals[i], kept, effort)
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

        What a goal cost when last looked at stands until its turn comes; only then is it looked at again.
        """
        distances = self._distances(node)
        queue = [(i not in self._hard, self._costs.get(i, 0.0), i, False) for i in pending]
        heapq.heapify(queue)
        while queue:
            is_easy, _, i, is_looked_at = heapq.heappop(queue)
            if is_looked_at:
                yield i
                continue
            if i == _NEXT_ACTION:
                cost = distances.to_action(self._moves.goals[node.taken]).cost
            else:
                cost = distances.to(self._goals[i])
            self._costs[i] = cost
            heapq.heappush(queue, (is_easy, cost, i, True))

    def _achieve(self, node: Node, goal: Wanted, kept: tuple[Wanted, ...], effort: Effort) -> Node | None:
        """Reach a goal part by part, or else as a whole."""
        while True:
            part = self._next_part(node, goal, kept, effort)
            if part is None:
                whole = effort._replace(states=_WHOLE * effort.states)
                return self._reach(node, Target((*kept, goal), node.taken), whole)
            node = part
            if self._distances(node).to(goal) == 0.0:
                return node

    def _next_part(self, node: Node, goal: Wanted, kept: tuple[Wanted, ...], effort: Effort) -> Node | None:
        distances = self._distances(node, kept)
        parts = distances.chosen(goal)
        if len(parts) < 2:
            return None
        costs = [distances.to(part) for part in parts]
        held = tuple([part for part, cost in zip(parts, costs, strict=True) if cost == 0.0])
        for i in sorted(range(len(parts)), key=lambda i: costs[i]):
            if costs[i] > 0.0:
                found = self._reach(node, Target((*kept, *held, parts[i]), node.taken), effort)
                if found is not None:
                    return found
        return None

    def _reach(self, node: Node, target: Target, effort: Effort) -> Node | None:
        return self._search.search(node, target, effort).node

    def _distances(self, node: Node, kept: Sequence[Wanted] = ()) -> Distances:
        return Distances(self._regression, node.state, self._moves.objects, kept)
