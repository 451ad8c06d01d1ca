"""What was found out lately need not be found out again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

LIMIT = 8_000_000
"""How many characters of operators are remembered at most, some 25 bytes each once they are read. Nine models
write some 1,800 different operators for a benchmark in under a million, and 1.5 million for the planner."""


class Memory(Generic[K, V]):
    """Results by what they are results of; beyond a limit the oldest is forgotten, to be found out again.

    However many answers are scored, and however long, memory stays flat. Any number of threads may ask.

    Args:
        limit: how much is remembered, in the unit of what `recall` is told.
    """

    def __init__(self, limit: int = LIMIT) -> None:
        self._limit = limit
        self._known: OrderedDict[K, tuple[V, int]] = OrderedDict()
        self._adding = Lock()
        self.size = 0

    def recall(self, key: K, size: int, find: Callable[[], V]) -> V:
        """The result for a key of that size, which ``find`` finds out where it is not remembered."""
        known = self._known.get(key)
        if known is not None:
            return known[0]
        result = find()
        with self._adding:
            if key not in self._known:  # no other thread has just found it, too
                self._known[key] = result, size
                self.size += size
            while self.size > self._limit:
                self.size -= self._known.popitem(last=False)[1][1]
        return result
