"""Best-first search: the nodes, open list, loop, limits and effort of all searches.

A best-first search visits the first open node until it finds a goal or no node is left. Searches differ in
the order of nodes, the allowed actions and the goal:

* `greedy_search` reaches conditions on a declared domain, guided by a heuristic;
* `eai.pddl.search` solves problems with given operators, guided by a heuristic on ground literals;
* `uniform_cost` of subgoal decomposition finds all shortest plans for one subgoal;
* `repair.search` finds fewest edits of a plan. Its nodes are edited plans instead of states.

Effort counts operations, never time, so equal input gives equal output.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import chain
from math import inf
from typing import Generic, TypeVar

S = TypeVar("S")
"""Type variable for states."""

A = TypeVar("A")
"""Type variable for actions."""

T = TypeVar("T")
"""Type variable for items of an open list: nodes, or nodes with the actions that expand them."""


class SearchEffort:
    """Counts the operations of a search: applied actions, estimated states, tried objects.

    Callers add their operations to `used`. If the limit is exceeded, `yield_objects_until_effort_limit`
    yields no more objects, so that every computation ends soon. The result of a computation is then invalid,
    so its caller must check `is_limit_exceeded`.

    Args:
        limit: maximum number of operations of all callers together; infinite by default.

    Attributes:
        limit: maximum number of operations.
        used: number of operations so far; the last operation may exceed the limit.
    """

    __slots__ = ("limit", "used")

    def __init__(self, limit: float = inf) -> None:
        self.limit = limit
        self.used = 0

    @property
    def is_limit_reached(self) -> bool:
        """Whether no further operation is allowed."""
        return self.used >= self.limit

    @property
    def is_limit_exceeded(self) -> bool:
        """Whether more operations were counted than the limit allows."""
        return self.used > self.limit

    def spend_and_check_limit(self, number: int = 1) -> bool:
        """Count operations. Return whether the limit is exceeded."""
        self.used += number
        return self.used > self.limit

    def yield_objects_until_effort_limit(self, object_names: Iterable[str]) -> Iterator[str]:
        """Yield names of objects until the limit of operations is exceeded. Each name is one operation."""
        for name in object_names:
            if self.spend_and_check_limit():
                return
            yield name


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a search. They count operations, never time.

    Attributes:
        states: maximum number of states that are reached and estimated.
        thorough: whether a failed search is continued, with another order of goals and unpromising actions.
            If not, a goal that seems unreachable stays without a result.
        bindings: maximum number of operations to find possible actions. Each tried value of a parameter is
            one operation, and each found action is `successor_generator.ACTION_BINDINGS` operations.
        looks: maximum number of tests for estimates. In a search in a `Domain`, each test of an action
            counts. In a search with operators from an answer, each test of a literal, option or effect
            counts; answers of nine models need fewer than 400,000 for every problem with a result.
    """

    states: int = 2_000
    thorough: bool = True
    looks: int = 700_000
    bindings: int = 3_000_000


class SearchEndReason(str, Enum):
    """Reason for the end of a search."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    """The search proved that the permitted actions lead to no goal."""
    STATES = "states"
    """The search reached its limit of states or of other operations, without a plan or a proof."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchNode(Generic[S, A]):
    """A state that a search has reached, and the path to this state.

    Attributes:
        state: the state.
        met: parts of the goal that are reached but cannot be read from the state, such as executed actions;
            their number, or a bit mask of them.
        depth: number of actions on the path.
        parent: the node before the last actions; None for the start.
        actions: the actions that lead from the parent to this node, one or several.
    """

    state: S
    met: int = 0
    depth: int = 0
    parent: SearchNode[S, A] | None = None
    actions: tuple[A, ...] = ()

    def list_actions(self) -> tuple[A, ...]:
        """Return the actions on the path to this node."""
        return tuple(chain.from_iterable([node.actions for node in self.list_path_nodes()]))

    def list_path_nodes(self) -> list[SearchNode[S, A]]:
        """Return the nodes on the path to this node, the start first."""
        nodes = []
        node: SearchNode[S, A] | None = self
        while node is not None:
            nodes.append(node)
            node = node.parent
        return nodes[::-1]


@dataclass(frozen=True, slots=True)
class SearchResult(Generic[A]):
    """The outcome of a search.

    Attributes:
        end: reason for the end of the search.
        plan: the plan; empty if no plan was found.
        states: number of states whose cost was estimated.
    """

    end: SearchEndReason
    plan: tuple[A, ...] = ()
    states: int = 0


class OpenList(Generic[T]):
    """A queue of items to visit, lowest rank first. No two items may have equal ranks."""

    def __init__(self) -> None:
        self._entries: list[tuple[tuple[float, ...], T]] = []

    def __bool__(self) -> bool:
        return bool(self._entries)

    def push(self, item: T, *rank: float) -> None:
        """Add an item with its rank."""
        heapq.heappush(self._entries, (rank, item))

    def pop(self) -> T | None:
        """Remove and return the item of lowest rank, or None if the list is empty."""
        return heapq.heappop(self._entries)[1] if self._entries else None


def run_best_first_search(
    pop_next_item: Callable[[], T | None], visit: Callable[[T], SearchNode[S, A] | SearchEndReason | None]
) -> SearchNode[S, A] | SearchEndReason:
    """Visit items until the search ends. Return the goal's node, or the reason why no goal was found.

    Args:
        pop_next_item: function that removes the next item from the open list and returns the item, or None if
            the list is empty.
        visit: function that tests an item, or expands it and adds its successors to the open list. It returns
            the goal's node, or the reason if the search ends at this item, else None.
    """
    while (item := pop_next_item()) is not None:
        end = visit(item)
        if end is not None:
            return end
    return SearchEndReason.UNREACHABLE
