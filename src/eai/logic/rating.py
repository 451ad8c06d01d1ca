"""The best ways to choose: for every size of an option, how many of its conditions can be good ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import reduce
from typing import TypeAlias

from typing_extensions import assert_never

from eai.logic.choice import AllOf, AnyOf, Choice, Choose, Leaf, Literal, Pairing, literals
from eai.logic.matching import heaviest_matching
from eai.logic.options import choice_options

Frontier: TypeAlias = dict[int, int]
"""For each possible number of conditions of an option, the largest number of good ones among them."""


def ratings(choice: Choice, good: Callable[[Literal], bool]) -> Frontier:
    """The best options of each size, as sets of conditions; empty if nothing can be chosen.

    Computed part by part, pairings by matching. Only where parts that are chosen together share conditions,
    or the pairs of a pairing differ in size, options are listed.
    """
    match choice:
        case Leaf(literal):
            return {1: int(good(literal))}
        case AnyOf(parts):
            return _merged(ratings(part, good) for part in parts)
        case AllOf(parts) if independent(parts):
            return reduce(combined, (ratings(part, good) for part in parts), {0: 0})
        case Choose(count, parts) if independent(parts):
            return _chosen(count, [ratings(part, good) for part in parts])
        case Pairing(count, cells) if independent(
            [cell for row in cells for cell in row if cell is not None]
        ):
            table = [[None if cell is None else ratings(cell, good) for cell in row] for row in cells]
            found = _paired(count, table)
            return _listed(choice, good) if found is None else found
        case AllOf() | Choose() | Pairing():
            return _listed(choice, good)
        case _:
            assert_never(choice)


def combined(first: Frontier, second: Frontier) -> Frontier:
    """What two independent choices come to together."""
    return alternatives((a + b, x + y) for a, x in first.items() for b, y in second.items())


def alternatives(rated: Iterable[tuple[int, int]]) -> Frontier:
    """The best of several options, each given by its size and its number of good conditions."""
    best: Frontier = {}
    for size, rating in rated:
        best[size] = max(rating, best.get(size, 0))
    return best


def independent(parts: Iterable[Choice]) -> bool:
    """Whether no condition stands in two of the parts."""
    seen: set[Literal] = set()
    for part in parts:
        own = frozenset(literals(part))
        if not seen.isdisjoint(own):
            return False
        seen |= own
    return True


def _merged(frontiers: Iterable[Frontier]) -> Frontier:
    return alternatives(entry for frontier in frontiers for entry in frontier.items())


def _listed(choice: Choice, good: Callable[[Literal], bool]) -> Frontier:
    return alternatives(
        (len(conditions), sum(map(good, conditions))) for conditions in map(frozenset, choice_options(choice))
    )


def _chosen(count: int, parts: Iterable[Frontier]) -> Frontier:
    """``count`` of the parts: ``by_number[k]`` is the frontier of k of those seen so far."""
    by_number: list[Frontier] = [{0: 0}, *({} for _ in range(count))]
    for part in parts:
        for k in range(count, 0, -1):
            by_number[k] = _merged([by_number[k], combined(by_number[k - 1], part)])
    return by_number[count]


def _paired(count: int, table: list[list[Frontier | None]]) -> Frontier | None:
    """A pairing whose pairs all have one size; None if they do not."""
    sizes = {size for row in table for cell in row if cell is not None for size in cell}
    if len(sizes) > 1:
        return None
    weights = [[None if not cell else next(iter(cell.values())) for cell in row] for row in table]
    best = heaviest_matching(weights, count)
    return {} if best is None else {count * sum(sizes): best}
