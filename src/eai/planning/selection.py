"""Which of several conditions to bring about, where the goal leaves that open: the cheap ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from eai.planning.subgoal import Subgoal

Cost: TypeAlias = Callable[[Subgoal], float]
"""What it costs to bring a condition about."""


def exactly(number: int, conditions: Sequence[Subgoal], cost: Cost) -> list[Subgoal]:
    """Exactly so many of the conditions, and the opposite of the others, as cheaply as can be."""
    opposites = [each.negated for each in conditions]

    def loss(i: int) -> tuple[bool, float]:
        own = cost(conditions[i])
        return own == float("inf"), own - cost(opposites[i])

    order = sorted(range(len(conditions)), key=loss)
    return [*(conditions[i] for i in order[:number]), *(opposites[i] for i in order[number:])]


def in_pairs(number: int, cells: Sequence[Sequence[Subgoal | None]], cost: Cost) -> list[Subgoal] | None:
    """So many cells, no two in one row or column, or None if that leads nowhere.

    The cheapest cell comes first, then the cheapest of those in other rows and columns, and so on.
    """
    ranked = sorted(
        (price, i, j)
        for i, row in enumerate(cells)
        for j, cell in enumerate(row)
        if cell is not None and (price := cost(cell)) < float("inf")
    )
    columns: dict[int, int] = {}
    for _, i, j in ranked:
        if len(columns) < number and i not in columns and j not in columns.values():
            columns[i] = j
    chosen = [cell for i, j in columns.items() if (cell := cells[i][j]) is not None]
    return chosen if len(chosen) == number else None
