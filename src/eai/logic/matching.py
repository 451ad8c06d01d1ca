"""Maximum matchings in bipartite graphs. They show whether goals about pairs hold."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple


def find_maximum_matching(adjacency: Sequence[Sequence[int]]) -> list[int | None]:
    """Match as many left vertices as possible, each with a different right vertex (Hopcroft and Karp 1973).

    Args:
        adjacency: for each left vertex, the numbers of its neighbours on the right.

    Returns:
        For each left vertex the number of the matched right vertex, or None. The size of the matching is the
        number of entries that are not None. Earlier neighbours are preferred; equal input gives equal output.

    Takes O(E sqrt(V)) time and does not recurse.
    """
    right_of_left: list[int | None] = [None] * len(adjacency)
    left_of_right: dict[int, int] = {}
    while layers := _find_layers(adjacency, right_of_left, left_of_right):
        unexplored = [iter(neighbours) for neighbours in adjacency]
        for left, matched in enumerate(right_of_left):
            if matched is None:
                _augment_matching(left, unexplored, layers, right_of_left, left_of_right)
    return right_of_left


def _find_layers(
    adjacency: Sequence[Sequence[int]], right_of_left: Sequence[int | None], left_of_right: dict[int, int]
) -> dict[int, int]:
    """Return the distance of each left vertex on alternating paths from unmatched left vertices.

    The result is {} if no alternating path makes the matching larger.
    """
    layers = {left: 0 for left, matched in enumerate(right_of_left) if matched is None}
    queue = deque(layers)
    augmentable = False
    while queue:
        left = queue.popleft()
        for right in adjacency[left]:
            holder = left_of_right.get(right)
            if holder is None:
                augmentable = True
            elif holder not in layers:
                layers[holder] = layers[left] + 1
                queue.append(holder)
    return layers if augmentable else {}


def _augment_matching(
    start: int,
    unexplored: Sequence[Iterator[int]],
    layers: dict[int, int],
    right_of_left: list[int | None],
    left_of_right: dict[int, int],
) -> None:
    """Augment the matching along the layers, by one path from a free left to a free right vertex.

    All searches of a phase share ``unexplored``: an edge that led one search nowhere is not tried by the next
    search.
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
        holder = left_of_right.get(right)
        if holder is None:
            for vertex, matched in zip(path, (*edges, right), strict=True):
                right_of_left[vertex] = matched
                left_of_right[matched] = vertex
            return
        if layers.get(holder) == layers[left] + 1:
            path.append(holder)
            edges.append(right)


def find_heaviest_matching(
    weights: Sequence[Sequence[float | None]], size: int
) -> list[tuple[int, int]] | None:
    """Return the ``size`` cells of a table with the largest total weight, no two in one row or column.

    Args:
        weights: the table, row by row; None marks a cell that must not be taken.
        size: number of cells to take.

    Returns:
        (row, column) of each cell, in the order of rows; None if there are no ``size`` such cells.

    Takes O(size * cells * rows) time.
    """
    column_of: dict[int, int] = {}
    if all(_extend_matching_by_one(weights, column_of) for _ in range(size)):
        return sorted(column_of.items())
    return None


def find_heaviest_matching_of_any_size(weights: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Return the cells of a table with the largest total weight, no two in one row or column.

    The number of cells is not fixed. Cells of weight 0 are never taken. Each cell is a pair (row, column), in
    the order of rows. Equal input gives equal output. Takes O(cells * rows * min(rows, columns)) time.

    Args:
        weights: the table, row by row, without negative weights.
    """
    column_of: dict[int, int] = {}
    # No step that adds weight takes a cell of weight 0. Suppose that the enlarged matching had such a cell.
    # Without the cell, it would be heavier than the matching before the step, and as large.
    # But the matching before the step was the heaviest matching of its size.
    while _extend_matching_by_one(weights, column_of, min_gain=1):
        pass
    return sorted(column_of.items())


def _extend_matching_by_one(
    weights: Sequence[Sequence[float | None]], column_of_row: dict[int, int], min_gain: float | None = None
) -> bool:
    """Enlarge the matching by one cell, along the augmenting path that adds most weight.

    Return whether the matching was enlarged. It is not if no path adds at least ``min_gain``.

    A matching is a set of cells of the table, no two in one row or column. The path may exchange cells. The
    matching stays the heaviest of its size (successive shortest paths). The added weight never grows from one
    call to the next.
    """
    row_of_column = {column: row for row, column in column_of_row.items()}
    paths = _find_heaviest_augmenting_paths(weights, column_of_row, row_of_column)
    free = [(gain, -column) for column, gain in paths.gain_by_column.items() if column not in row_of_column]
    gain, end = max(free, default=(0, 0))
    if not free or (min_gain is not None and gain < min_gain):
        return False
    column: int | None = -end
    while column is not None:
        row = paths.last_row_by_column[column]
        released, column_of_row[row] = column_of_row.get(row), column
        column = released
    return True


class _AugmentingPaths(NamedTuple):
    """For each column of a table, the augmenting path to it that adds most weight to a matching.

    Attributes:
        gain_by_column: weight that the path to each column adds to the matching.
        last_row_by_column: row of the cell in which the path to each column ends.
    """

    gain_by_column: dict[int, float]
    last_row_by_column: dict[int, int]


def _find_heaviest_augmenting_paths(
    weights: Sequence[Sequence[float | None]],
    column_of_row: Mapping[int, int],
    row_of_column: Mapping[int, int],
) -> _AugmentingPaths:
    """Return for each column the augmenting path to it that adds most weight to a matching.

    A path starts in a row without a cell of the matching. It adds a cell, removes the matching's cell in the
    same column, goes on from the row of the removed cell, and so on.
    """
    reached = {row: 0.0 for row in range(len(weights)) if row not in column_of_row}
    gains: dict[int, float] = {}
    came_from: dict[int, int] = {}
    queue = deque(reached)
    while queue:
        row = queue.popleft()
        for column, weight in enumerate(weights[row]):
            if weight is None or column_of_row.get(row) == column:
                continue
            gain = reached[row] + weight
            if column not in gains or gain > gains[column]:
                gains[column], came_from[column] = gain, row
                holder = row_of_column.get(column)
                if holder is not None:
                    reached[holder] = gain - (weights[holder][column] or 0)
                    queue.append(holder)
    return _AugmentingPaths(gains, came_from)
