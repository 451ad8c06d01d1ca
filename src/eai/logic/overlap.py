"""The option of a goal that shares most with what is said of it, found without listing the options.

Conditions are numbered, and sets of them are bit masks (bit i = condition i).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import reduce
from operator import attrgetter, or_
from typing import TypeAlias

from typing_extensions import assert_never

from eai.logic.choice import AllOf, AnyOf, Choice, Choose, Leaf, Literal, Pairing
from eai.logic.matching import heaviest_matching

SHARED = 1 << 20
"""The weight of a condition that is shared against the conditions that are not, of which each counts 1."""


class _Overlap:
    """One option: the more it shares with what is said, and the shorter it is, the better its score."""

    __slots__ = ("conditions", "score")

    def __init__(self, score: int, conditions: int) -> None:
        self.score = score
        self.conditions = conditions


BestOverlap: TypeAlias = Callable[[int], "_Overlap | None"]
"""Gives the best option for the conditions that are said; None if there are no options."""


def best_overlap(choice: Choice, number: Callable[[Literal], int]) -> BestOverlap:
    """A function that finds the option that shares most conditions with what is said.

    Of several the shortest is taken, of several of those the first. Parts that are chosen together are rated
    each by itself: a condition that stands in two of them counts in both.

    Args:
        choice: the goal's options.
        number: the number of each condition; equal conditions have equal numbers.
    """
    match choice:
        case Leaf(literal):
            return _conditions(1 << number(literal))
        case AllOf(parts):
            leaves = [1 << number(part.literal) for part in parts if isinstance(part, Leaf)]
            together = _conditions(reduce(or_, leaves, 0))
            others = [best_overlap(part, number) for part in parts if not isinstance(part, Leaf)]
            return _all_of((together, *others)) if others else together
        case AnyOf(parts):
            return _any_of([best_overlap(part, number) for part in parts])
        case Choose(count, parts):
            return _some_of(count, [best_overlap(part, number) for part in parts])
        case Pairing(count, cells):
            return _paired(
                count,
                [[None if cell is None else best_overlap(cell, number) for cell in row] for row in cells],
            )
        case _:
            assert_never(choice)


def _conditions(mask: int) -> BestOverlap:
    size = mask.bit_count()
    return lambda said: _Overlap((mask & said).bit_count() * SHARED - size, mask)


def _all_of(parts: Sequence[BestOverlap]) -> BestOverlap:
    return lambda said: _together([part(said) for part in parts])


def _any_of(parts: Sequence[BestOverlap]) -> BestOverlap:
    def first_of_best(said: int) -> _Overlap | None:
        best: _Overlap | None = None
        for part in parts:
            each = part(said)
            if each is not None and (best is None or each.score > best.score):
                best = each
        return best

    return parts[0] if len(parts) == 1 else first_of_best


def _some_of(count: int, parts: Sequence[BestOverlap]) -> BestOverlap:
    def best(said: int) -> _Overlap | None:
        found = [each for part in parts if (each := part(said)) is not None]
        if len(found) < count:
            return None
        return _together(sorted(found, key=_score, reverse=True)[:count])

    return best


def _paired(count: int, table: Sequence[Sequence[BestOverlap | None]]) -> BestOverlap:
    def best(said: int) -> _Overlap | None:
        found = [[None if cell is None else cell(said) for cell in row] for row in table]
        weights = [[None if each is None else each.score for each in row] for row in found]
        cells = heaviest_matching(weights, count)
        return None if cells is None else _together([found[row][column] for row, column in cells])

    return best


def _together(parts: Iterable[_Overlap | None]) -> _Overlap | None:
    """Options of several parts as one; None if a part has none."""
    score = conditions = 0
    for part in parts:
        if part is None:
            return None
        score += part.score
        conditions |= part.conditions
    return _Overlap(score, conditions)


_score = attrgetter("score")
