"""Effort: how much a computation may do, counted and never timed, so that equal input gives equal output."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf


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

    def at(self, names: Iterable[str]) -> Iterator[str]:
        """The names, as far as they may be looked at."""
        for name in names:
            self.used += 1
            if self.used > self.limit:
                return
            yield name
