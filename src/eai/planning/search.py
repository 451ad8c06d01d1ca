"""Search: what all searches of this package share, whatever they search for and in.

A best-first search visits the open node that comes first until it finds a goal, or nothing is left. In which
order nodes come (a heuristic, the length of the way), which actions are permitted and what is a goal differs:
`greedy_search` reaches conditions on a declared domain, `eai.pddl.search` solves problems with given
operators, and the uniform-cost search of subgoal decomposition carries out subgoals. Effort is counted and
never timed, so that equal input gives equal output.
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
"""A state."""

A = TypeVar("A")
"""An action."""

T = TypeVar("T")
"""An item to visit: a node, or one with the actions by which it is to be expanded."""


class Effort:
    """A number of things that may be done: actions applied, states estimated, objects looked at.

    Who does something adds it to `used`. Beyond the limit there are no more objects (`at`), so that any
    computation comes to its end soon; what it finds then means nothing, and who made the computation asks
    whether the effort is exceeded.

    Args:
        limit: how many are allowed, to all who share the effort; any number by default.

    Attributes:
        limit: how many are allowed.
        used: how many there have been; more than allowed if the last thing done was dear.
    """

    __slots__ = ("limit", "used")

    def __init__(self, limit: float = inf) -> None:
        self.limit = limit
        self.used = 0

    @property
    def is_used_up(self) -> bool:
        """Whether nothing more is allowed."""
        return self.used >= self.limit

    @property
    def is_exceeded(self) -> bool:
        """Whether there was more to do than is allowed."""
        return self.used > self.limit

    def spend(self, number: int = 1) -> bool:
        """Count things that are done, and return whether that is more than is allowed."""
        self.used += number
        return self.used > self.limit

    def at(self, names: Iterable[str]) -> Iterator[str]:
        """The names, as far as they may be looked at."""
        for name in names:
            if self.spend():
                return
            yield name


@dataclass(frozen=True, slots=True)
class Limits:
    """How much a search may do, counted and never timed.

    Attributes:
        states: states that may be reached and estimated.
        thorough: whether goals are tried in another order, and actions that do not look promising are taken,
            when nothing else is left. Where they are not, nothing is said of what looks out of reach.
        bindings: how many values parameters may be given to find the actions of a search on a declared
            domain; each action counts for some more.
        looks: how many literals, options and effects a search with given operators may look at, or how many
            actions the estimates of one on a declared domain, in all states together; no problem of nine
            models' operators that is decided needs 400,000.
    """

    states: int = 2_000
    thorough: bool = True
    looks: int = 700_000
    bindings: int = 3_000_000


class SearchEnd(str, Enum):
    """How a search ended."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    """A proof: no state that the permitted actions lead to is a goal."""
    STATES = "states"
    """A limit was reached."""


@dataclass(frozen=True, slots=True, eq=False)
class Node(Generic[S, A]):
    """A state that a search has reached, and the way to it.

    Attributes:
        state: the state.
        met: the part of the goal that has been met by now, where the state alone does not show it: how many
            of several, or the mask of those.
        depth: how many actions led here.
        parent: where the last of them were taken; None where the search began.
        actions: those, one or several.
    """

    state: S
    met: int = 0
    depth: int = 0
    parent: Node[S, A] | None = None
    actions: tuple[A, ...] = ()

    def plan(self) -> tuple[A, ...]:
        """The actions that led here."""
        return tuple(chain.from_iterable([node.actions for node in self.way()]))

    def way(self) -> list[Node[S, A]]:
        """The nodes on the way here, where the search began first."""
        found = []
        node: Node[S, A] | None = self
        while node is not None:
            found.append(node)
            node = node.parent
        return found[::-1]


@dataclass(frozen=True, slots=True)
class SearchResult(Generic[A]):
    """The outcome of a search.

    Attributes:
        end: how it ended.
        plan: the plan, if it was solved.
        states: how many states were estimated.
    """

    end: SearchEnd
    plan: tuple[A, ...] = ()
    states: int = 0


class OpenList(Generic[T]):
    """The items to be visited, that of the least rank first. No two may have the same rank."""

    def __init__(self) -> None:
        self._entries: list[tuple[tuple[float, ...], T]] = []

    def __bool__(self) -> bool:
        return bool(self._entries)

    def push(self, item: T, *rank: float) -> None:
        """Put something where its rank says."""
        heapq.heappush(self._entries, (rank, item))

    def pop(self) -> T | None:
        """Take what comes first; None if nothing is left."""
        return heapq.heappop(self._entries)[1] if self._entries else None


def best_first(
    following: Callable[[], T | None], visit: Callable[[T], Node[S, A] | SearchEnd | None]
) -> Node[S, A] | SearchEnd:
    """Visit what comes first until that ends the search: the goal, or why there is none.

    Args:
        following: takes the node that comes next from the open list, if any is left.
        visit: tests a node, or expands it by the permitted actions and puts what they lead to into the open
            list; the goal, or why the search ends, if it does.
    """
    while (item := following()) is not None:
        found = visit(item)
        if found is not None:
            return found
    return SearchEnd.UNREACHABLE
