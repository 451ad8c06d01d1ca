from __future__ import annotations

from itertools import permutations

from hypothesis import given
from hypothesis import strategies as st

from eai.pddl.assignment import heaviest_pairs

TABLES = st.integers(0, 4).flatmap(
    lambda columns: st.lists(st.lists(st.integers(0, 5), min_size=columns, max_size=columns), max_size=4)
)


def best_by_trying(weights: list[list[int]]) -> int:
    rows, columns = len(weights), len(weights[0]) if weights else 0
    size = max(rows, columns)
    square = [[weights[i][j] if i < rows and j < columns else 0 for j in range(size)] for i in range(size)]
    return max(sum(square[i][j] for i, j in enumerate(order)) for order in permutations(range(size)))


@given(TABLES)
def test_the_pairs_weigh_most_and_use_nothing_twice(weights: list[list[int]]) -> None:
    pairs = heaviest_pairs(weights)
    assert len({pair.row for pair in pairs}) == len({pair.column for pair in pairs}) == len(pairs)
    assert all(weights[pair.row][pair.column] > 0 for pair in pairs)
    assert sum(weights[pair.row][pair.column] for pair in pairs) == best_by_trying(weights)


def test_more_rows_than_columns_are_paired_by_row() -> None:
    assert heaviest_pairs([[1], [3], [2]]) == [(1, 0)]
    assert heaviest_pairs([]) == heaviest_pairs([[], []]) == []
