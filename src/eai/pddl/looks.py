"""Bounded work: how much may be looked at, such as objects by quantifiers, counted and never timed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf


class Looks:
    """A number of things, objects or others, that may be looked at.

    Beyond it there are no more objects, so that any computation comes to its end soon; what it finds then
    means nothing, and who made the computation asks whether the looks are used up.

    Args:
        limit: how many may be looked at, by all who share the looks; any number by default.

    Attributes:
        used: how many have been looked at; who looks at other things than `at` yields adds them here.
    """

    __slots__ = ("_limit", "used")

    def __init__(self, limit: float = inf) -> None:
        self._limit = limit
        self.used = 0

    @property
    def are_used_up(self) -> bool:
        """Whether there was more to look at than is allowed."""
        return self.used > self._limit

    def at(self, names: Iterable[str]) -> Iterator[str]:
        """The names, as far as they may be looked at."""
        for name in names:
            self.used += 1
            if self.used > self._limit:
                return
            yield name
