"""The assignment problem: pair rows with columns so that the pairs weigh as much as possible together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Pair(NamedTuple):
    """A row and the column it is given."""

    row: int
    column: int


def heaviest_pairs(weights: Sequence[Sequence[int]]) -> list[Pair]:
    """Pairs of rows and columns, none used twice, of the greatest total weight; by row.

    Args:
        weights: for each row its non-negative weight with every column; all rows are equally long.

    Pairs of weight 0 are left out. Equal input gives equal output. Takes O(rows² columns) time (the
    Hungarian method with shortest augmenting paths, Jonker and Volgenant 1987), if there are no more rows
    than columns.
    """
    if not weights or not weights[0]:
        return []
    if len(weights) > len(weights[0]):
        turned = heaviest_pairs(list(zip(*weights, strict=True)))
        return sorted(Pair(column, row) for row, column in turned)
    owner = _Assignment(weights).solve()
    pairs = sorted(Pair(row, column) for column, row in enumerate(owner) if row is not None)
    return [pair for pair in pairs if weights[pair.row][pair.column]]


class _Assignment:
    """Rows are added one by one, each along a shortest path of reduced costs (cost = minus weight)."""

    def __init__(self, weights: Sequence[Sequence[int]]) -> None:
        self._weights = weights
        self._columns = len(weights[0])
        self._row_price = [0] * len(weights)
        self._column_price = [0] * self._columns

    def solve(self) -> list[int | None]:
        """For each column its row."""
        owner: list[int | None] = [None] * self._columns
        for row in range(len(self._weights)):
            self._add(row, owner)
        return owner

    def _add(self, start: int, owner: list[int | None]) -> None:
        infinite = float("inf")
        slack: list[float] = [infinite] * self._columns
        before: list[int | None] = [None] * self._columns
        reached = [False] * self._columns
        row, column = start, None
        while True:
            if column is not None:
                reached[column] = True
            delta, best = infinite, 0
            for other in range(self._columns):
                if reached[other]:
                    continue
                reduced = -self._weights[row][other] - self._row_price[row] - self._column_price[other]
                if reduced < slack[other]:
                    slack[other], before[other] = reduced, column
                if slack[other] < delta:
                    delta, best = slack[other], other
            self._shift(start, owner, reached, slack, int(delta))
            column = best
            holder = owner[best]
            if holder is None:
                break
            row = holder
        _flip(column, start, before, owner)

    def _shift(
        self, start: int, owner: list[int | None], reached: list[bool], slack: list[float], delta: int
    ) -> None:
        self._row_price[start] += delta
        for column, inside in enumerate(reached):
            holder = owner[column]
            if inside and holder is not None:
                self._row_price[holder] += delta
                self._column_price[column] -= delta
            else:
                slack[column] -= delta


def _flip(column: int, start: int, before: list[int | None], owner: list[int | None]) -> None:
    while (previous := before[column]) is not None:
        owner[column] = owner[previous]
        column = previous
    owner[column] = start
