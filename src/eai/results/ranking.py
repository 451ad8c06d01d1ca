"""How far two or more orders of the same things agree."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from itertools import combinations


def kendall_tau_b(first: Sequence[float], second: Sequence[float]) -> float | None:
    """Kendall's tau-b of two ratings of the same things: 1 the same order, -1 the reverse.

    Returns:
        None where one of them rates all alike: then there is no order to agree with.
    """
    concordant = ties_first = ties_second = 0
    for (a, b), (c, d) in combinations(zip(first, second, strict=True), 2):
        concordant += _sign(a - c) * _sign(b - d)
        ties_first += a == c
        ties_second += b == d
    pairs = math.comb(len(first), 2)
    scale = (pairs - ties_first) * (pairs - ties_second)
    return concordant / math.sqrt(scale) if scale else None


def kendall_w(ratings: Sequence[Sequence[float]]) -> float | None:
    """Kendall's coefficient of concordance of several ratings of the same things, corrected for ties.

    0 no agreement, 1 the same order; of two ratings it is (1 + Spearman's correlation) / 2.

    Returns:
        None for fewer than two ratings or things, or where all are rated alike.
    """
    raters, things = len(ratings), len(ratings[0]) if ratings else 0
    if raters < 2 or things < 2:
        return None
    ranks = [average_ranks(rating) for rating in ratings]
    sums = [sum(column) for column in zip(*ranks, strict=True)]
    mean = sum(sums) / things
    ties = sum(n**3 - n for rating in ratings for n in Counter(rating).values())
    largest = raters**2 * (things**3 - things) - raters * ties
    return 12 * sum((each - mean) ** 2 for each in sums) / largest if largest else None


def average_ranks(rating: Sequence[float]) -> list[float]:
    """The rank of each thing from 1, the lowest first; equal ones share the mean of theirs."""
    places: dict[float, list[int]] = {}
    for rank, value in enumerate(sorted(rating), 1):
        places.setdefault(value, []).append(rank)
    return [sum(places[value]) / len(places[value]) for value in rating]


def shared_at_top(first: Sequence[float], second: Sequence[float], most: int) -> int:
    """How many things are among the best in both; of equal ones the earlier counts as better."""
    best = [sorted(range(len(each)), key=lambda i: (-each[i], i))[:most] for each in (first, second)]
    return len(set(best[0]) & set(best[1]))


def holm(p_values: Sequence[float]) -> list[float]:
    """The p values after Holm's correction for their number, in the same order."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected = [0.0] * len(p_values)
    largest = 0.0
    for done, place in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - done) * p_values[place]))
        corrected[place] = largest
    return corrected


def two_way_shares(cells: Sequence[Sequence[float]]) -> tuple[float, float, float] | None:
    """How much of the variance of a table is its rows', its columns' and the rest's, as shares of 1.

    Two-way, without replication; None where nothing varies.
    """
    rows, columns = len(cells), len(cells[0])
    mean = sum(map(sum, cells)) / (rows * columns)
    of_rows = columns * sum((sum(row) / columns - mean) ** 2 for row in cells)
    of_columns = rows * sum((sum(column) / rows - mean) ** 2 for column in zip(*cells, strict=True))
    whole = sum((cell - mean) ** 2 for row in cells for cell in row)
    if whole < _ROUNDING:
        return None
    return of_rows / whole, of_columns / whole, max(0.0, 1 - (of_rows + of_columns) / whole)


_ROUNDING = 1e-9


def _sign(number: float) -> int:
    return (number > 0) - (number < 0)
