"""Group (key, value) pairs by their keys, and apply functions to groups of items."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias, TypeVar

K = TypeVar("K", bound=Hashable)
V = TypeVar("V")

MapItems: TypeAlias = Callable[[Callable[[Sequence[Any]], Sequence[Any]], Sequence[Any]], Iterable[Any]]
"""Function that applies a function to groups of items, and yields a result for each item, in order."""


def group_pairs(pairs: Iterable[tuple[K, V]]) -> dict[K, list[V]]:
    """Return a mapping from the keys of (key, value) pairs to lists of the values of each key.

    Keys and values keep the order of the pairs.
    """
    groups: dict[K, list[V]] = {}
    for key, value in pairs:
        groups.setdefault(key, []).append(value)
    return groups


def map_one_by_one(work: Callable[[Sequence[K]], Sequence[V]], items: Iterable[K]) -> Iterator[V]:
    """Call a function with groups of one item, in this process, and yield the results in order."""
    for item in items:
        yield from work((item,))
