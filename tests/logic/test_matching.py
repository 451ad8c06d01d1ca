"""Maximum matchings compared with exhaustive search."""

from __future__ import annotations

from functools import cache
from itertools import combinations, permutations

from hypothesis import given
from hypothesis import strategies as st

from eai.logic.matching import (
    find_heaviest_matching,
    find_heaviest_matching_of_any_size,
    find_maximum_matching,
)

GRAPHS = st.lists(st.lists(st.integers(0, 7), max_size=6), max_size=8)


def exhaustive_size(adjacency: list[list[int]]) -> int:
    """Return the size of a largest matching, by trying every choice for every left vertex."""

    @cache
    def best(left: int, taken: frozenset[int]) -> int:
        if left == len(adjacency):
            return 0
        skipped = best(left + 1, taken)
        return max(
            [
                skipped,
                *(1 + best(left + 1, taken | {right}) for right in adjacency[left] if right not in taken),
            ]
        )

    return best(0, frozenset())


@given(GRAPHS)
def test_the_result_is_a_matching_of_maximum_size(adjacency: list[list[int]]) -> None:
    partner = find_maximum_matching(adjacency)
    used = [right for right in partner if right is not None]
    assert len(partner) == len(adjacency)
    assert len(set(used)) == len(used)
    assert all(right is None or right in adjacency[left] for left, right in enumerate(partner))
    assert len(used) == exhaustive_size(adjacency)


def test_an_earlier_choice_is_displaced_if_needed() -> None:
    assert find_maximum_matching([[0, 1], [0]]) == [1, 0]


def test_an_empty_graph_has_an_empty_matching() -> None:
    assert find_maximum_matching([]) == []
    assert find_maximum_matching([[], []]) == [None, None]


def test_long_augmenting_paths_do_not_recurse() -> None:
    size = 3000
    adjacency = [[left, left + 1] for left in range(size)] + [[0]]
    assert None not in find_maximum_matching(adjacency)


TABLES = st.tuples(st.integers(0, 4), st.integers(0, 4)).flatmap(
    lambda shape: st.lists(
        st.lists(st.none() | st.integers(-2, 5), min_size=shape[1], max_size=shape[1]),
        min_size=shape[0],
        max_size=shape[0],
    )
)


@given(TABLES, st.integers(0, 4))
def test_the_heaviest_matching_is_the_best_of_all(table: list[list[int | None]], size: int) -> None:
    width = len(table[0]) if table else 0
    totals = []
    for rows in combinations(range(len(table)), size):
        for columns in permutations(range(width), size):
            cells = [table[i][j] for i, j in zip(rows, columns, strict=True)]
            if None not in cells:
                totals.append(sum(cell for cell in cells if cell is not None))
    cells = find_heaviest_matching(table, size)
    if cells is None:
        assert totals == []
        return
    assert len(cells) == len({row for row, _ in cells}) == len({column for _, column in cells}) == size
    assert sum(table[row][column] or 0 for row, column in cells) == max(totals)


def test_the_heaviest_matching_of_a_large_table_is_found() -> None:
    size = 60
    table = [[10 if (i + 7) % size == j else (i * j) % 7 for j in range(size)] for i in range(size)]
    cells = find_heaviest_matching(table, size)
    assert cells is not None
    assert sum(table[row][column] for row, column in cells) == 10 * size


WEIGHTS = st.integers(0, 4).flatmap(
    lambda columns: st.lists(st.lists(st.integers(0, 5), min_size=columns, max_size=columns), max_size=4)
)


def heaviest_by_trying(weights: list[list[int]]) -> int:
    rows, columns = len(weights), len(weights[0]) if weights else 0
    size = max(rows, columns)
    square = [[weights[i][j] if i < rows and j < columns else 0 for j in range(size)] for i in range(size)]
    return max(sum(square[i][j] for i, j in enumerate(order)) for order in permutations(range(size)))


@given(WEIGHTS)
def test_the_heaviest_pairs_use_no_row_or_column_twice(weights: list[list[int]]) -> None:
    pairs = find_heaviest_matching_of_any_size(weights)
    assert len({row for row, _ in pairs}) == len({column for _, column in pairs}) == len(pairs)
    assert all(weights[row][column] > 0 for row, column in pairs)
    assert sum(weights[row][column] for row, column in pairs) == heaviest_by_trying(weights)


def test_more_rows_than_columns_are_paired_by_row() -> None:
    assert find_heaviest_matching_of_any_size([[1], [3], [2]]) == [(1, 0)]
    assert find_heaviest_matching_of_any_size([]) == find_heaviest_matching_of_any_size([[], []]) == []
