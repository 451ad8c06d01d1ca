"""Maximum matching in bipartite graphs: what decides quantified goals without listing their options."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence


def maximum_matching(adjacency: Sequence[Sequence[int]]) -> list[int | None]:
    """Match as many left vertices as possible, each with a right vertex of its own (Hopcroft and Karp 1973).

    Args:
        adjacency: for each left vertex ``0 .. len(adjacency) - 1`` the numbers of its right neighbours.

    Returns:
        For each left vertex the right vertex it is matched with, or None. The size of the matching is the
        number of entries that are not None. Earlier neighbours are preferred; equal input gives equal output.

    Takes O(E sqrt(V)) time and does not recurse.
    """
    partner: list[int | None] = [None] * len(adjacency)
    owner: dict[int, int] = {}
    while layers := _layers(adjacency, partner, owner):
        unexplored = [iter(neighbours) for neighbours in adjacency]
        for left, matched in enumerate(partner):
            if matched is None:
                _augment(left, unexplored, layers, partner, owner)
    return partner


def _layers(
    adjacency: Sequence[Sequence[int]], partner: Sequence[int | None], owner: dict[int, int]
) -> dict[int, int]:
    """Distance of left vertices from the free ones on alternating paths; empty if none can be augmented."""
    layers = {left: 0 for left, matched in enumerate(partner) if matched is None}
    queue = deque(layers)
    augmentable = False
    while queue:
        left = queue.popleft()
        for right in adjacency[left]:
            holder = owner.get(right)
            if holder is None:
                augmentable = True
            elif holder not in layers:
                layers[holder] = layers[left] + 1
                queue.append(holder)
    return layers if augmentable else {}


def _augment(
    start: int,
    unexplored: Sequence[Iterator[int]],
    layers: dict[int, int],
    partner: list[int | None],
    owner: dict[int, int],
) -> None:
    """Flip one alternating path from a free left vertex along the layers to a free right one, if any.

    ``unexplored`` is shared by all searches of a phase: an edge that led nowhere is not tried again.
    """
    path = [start]
    edges: list[int] = []
    while path:
        left = path[-1]
        right = next(unexplored[left], None)
        if right is None:
            path.pop()
            if edges:
                edges.pop()
            continue
        holder = owner.get(right)
        if holder is None:
            for vertex, matched in zip(path, (*edges, right), strict=True):
                partner[vertex] = matched
                owner[matched] = vertex
            return
        if layers.get(holder) == layers[left] + 1:
            path.append(holder)
            edges.append(right)


def heaviest_matching(weights: Sequence[Sequence[int | None]], size: int) -> int | None:
    """The largest total weight of ``size`` cells of a table, no two in one row or column.

    Args:
        weights: the table, row by row; None marks a cell that must not be taken.
        size: how many cells to take.

    Returns:
        The total weight, or None if there are no ``size`` such cells.

    Cells are added one at a time along the path that gains most, which keeps the choice the best one for
    every size; takes O(size * cells * rows) time.
    """
    column_of: dict[int, int] = {}
    row_of: dict[int, int] = {}
    total = 0
    for _ in range(size):
        gains, came_from = _best_gains(weights, column_of, row_of)
        free = [(gain, column) for column, gain in gains.items() if column not in row_of]
        if not free:
            return None
        gain, column = max(free, key=lambda end: (end[0], -end[1]))
        total += gain
        while True:
            row = came_from[column]
            released = column_of.get(row)
            column_of[row], row_of[column] = column, row
            if released is None:
                break
            column = released
    return total


def _best_gains(
    weights: Sequence[Sequence[int | None]], column_of: dict[int, int], row_of: dict[int, int]
) -> tuple[dict[int, int], dict[int, int]]:
    """For each column the most that an alternating path from a free row to it gains, and its last row."""
    reached = {row: 0 for row in range(len(weights)) if row not in column_of}
    gains: dict[int, int] = {}
    came_from: dict[int, int] = {}
    queue = deque(reached)
    while queue:
        row = queue.popleft()
        for column, weight in enumerate(weights[row]):
            if weight is None or column_of.get(row) == column:
                continue
            gain = reached[row] + weight
            if column not in gains or gain > gains[column]:
                gains[column], came_from[column] = gain, row
                holder = row_of.get(column)
                if holder is not None:
                    reached[holder] = gain - (weights[holder][column] or 0)
                    queue.append(holder)
    return gains, came_from
