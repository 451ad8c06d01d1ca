"""What was found out lately need not be found out again."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress
from typing import Generic, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

LIMIT = 4096
"""How much is remembered at most. Nine models write some 1,800 different operators for a benchmark."""


class Memory(Generic[K, V]):
    """Results by what they are results of; beyond a limit the oldest is forgotten, to be found out again.

    However many answers are scored, memory stays flat. Any number of threads may ask.

    Args:
        limit: how many results are remembered.
    """

    def __init__(self, limit: int = LIMIT) -> None:
        self._limit = limit
        self._known: OrderedDict[K, V] = OrderedDict()

    def __len__(self) -> int:
        return len(self._known)

    def recall(self, key: K, find: Callable[[], V]) -> V:
        """The result for a key, which ``find`` finds out where it is not remembered."""
        result = self._known.get(key)
        if result is None:
            result = self._known[key] = find()
            if len(self._known) > self._limit:
                with suppress(KeyError):  # another thread has just forgotten it
                    self._known.popitem(last=False)
        return result
