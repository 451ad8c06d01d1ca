"""Best-first search: the nodes, open list, loop, limits and effort of all searches."""

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
"""Type of an item of an open list: a node, or a node with the actions that expand it."""


class Effort:
    """Counts the operations of a search: applied actions, estimated states, tried objects.

    Callers add to `used`. Beyond the limit, `take_within_limit` yields no more objects, so that every
    computation ends soon. Its result is then invalid, and its caller checks `is_exceeded`.

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
    def is_used_up(self) -> bool:
        """Whether no further operation is allowed."""
        return self.used >= self.limit

    @property
    def is_exceeded(self) -> bool:
        """Whether more operations were needed than allowed."""
        return self.used > self.limit

    def spend(self, number: int = 1) -> bool:
        """Count operations, and return whether there are more than allowed."""
        self.used += number
        return self.used > self.limit

    def take_within_limit(self, names: Iterable[str]) -> Iterator[str]:
        """Yield the names of objects until the limit is exceeded; each counts as one operation."""
        for name in names:
            if self.spend():
                return
            yield name


@dataclass(frozen=True, slots=True)
class Limits:
    """The limits of a search, counted and never timed.

    Attributes:
        states: maximum number of states that are reached and estimated.
        thorough: whether to try another order of goals, and unpromising actions, as a last resort. If not, a
            goal that looks out of reach stays undecided.
        bindings: maximum number of values given to parameters to find actions on a declared domain; each
            action counts for `successor_generator.ACTION_BINDINGS` more.
        looks: maximum number of tested literals, options and effects in a search with given operators, or of
            tested actions in estimates on a declared domain. Operators of nine models' answers need fewer
            than 400,000 for every decided problem.
    """

    states: int = 2_000
    thorough: bool = True
    looks: int = 700_000
    bindings: int = 3_000_000


class SearchEnd(str, Enum):
    """Reason for the end of a search."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    """The search proved that the permitted actions lead to no goal."""
    STATES = "states"
    """The search reached a limit."""


@dataclass(frozen=True, slots=True, eq=False)
class Node(Generic[S, A]):
    """A state that a search has reached, and the path to it.

    Attributes:
        state: the state.
        met: the achieved part of the goal, if the state does not show it: a number of parts, or their mask.
        depth: number of actions on the path.
        parent: the node before the last actions; None for the start.
        actions: the actions that lead here from the parent, one or several.
    """

    state: S
    met: int = 0
    depth: int = 0
    parent: Node[S, A] | None = None
    actions: tuple[A, ...] = ()

    def plan(self) -> tuple[A, ...]:
        """Return the actions on the path."""
        return tuple(chain.from_iterable([node.actions for node in self.path()]))

    def path(self) -> list[Node[S, A]]:
        """Return the nodes on the path, the start first."""
        nodes = []
        node: Node[S, A] | None = self
        while node is not None:
            nodes.append(node)
            node = node.parent
        return nodes[::-1]


@dataclass(frozen=True, slots=True)
class SearchResult(Generic[A]):
    """The outcome of a search.

    Attributes:
        end: how the search ended.
        plan: the plan; empty if none was found.
        states: number of estimated states.
    """

    end: SearchEnd
    plan: tuple[A, ...] = ()
    states: int = 0


class OpenList(Generic[T]):
    """A queue of the items to visit, lowest rank first. Every item needs a rank of its own."""

    def __init__(self) -> None:
        self._entries: list[tuple[tuple[float, ...], T]] = []

    def __bool__(self) -> bool:
        return bool(self._entries)

    def push(self, item: T, *rank: float) -> None:
        """Add an item by its rank."""
        heapq.heappush(self._entries, (rank, item))

    def pop(self) -> T | None:
        """Remove and return the first item, or None if the list is empty."""
        return heapq.heappop(self._entries)[1] if self._entries else None


def best_first(
    following: Callable[[], T | None], visit: Callable[[T], Node[S, A] | SearchEnd | None]
) -> Node[S, A] | SearchEnd:
    """Visit items until the search ends; return the goal, or the reason why none was found.

    Args:
        following: removes and returns the next item of the open list, or None if the list is empty.
        visit: tests an item, or expands it and adds its successors to the open list. It returns the goal or
            the reason if the search ends there, else None.
    """
    while (item := following()) is not None:
        end = visit(item)
        if end is not None:
            return end
    return SearchEnd.UNREACHABLE
