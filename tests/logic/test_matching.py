"""Maximum matchings against exhaustive search."""

from __future__ import annotations

from functools import cache

from hypothesis import given
from hypothesis import strategies as st

from eai.logic.matching import maximum_matching

GRAPHS = st.lists(st.lists(st.integers(0, 7), max_size=6), max_size=8)


def exhaustive_size(adjacency: list[list[int]]) -> int:
    """Largest matching by trying every choice for every left vertex."""

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
def test_is_a_matching_of_maximum_size(adjacency: list[list[int]]) -> None:
    partner = maximum_matching(adjacency)
    used = [right for right in partner if right is not None]
    assert len(partner) == len(adjacency)
    assert len(set(used)) == len(used)
    assert all(right is None or right in adjacency[left] for left, right in enumerate(partner))
    assert len(used) == exhaustive_size(adjacency)


def test_displaces_an_earlier_choice() -> None:
    assert maximum_matching([[0, 1], [0]]) == [1, 0]


def test_nothing_to_match() -> None:
    assert maximum_matching([]) == []
    assert maximum_matching([[], []]) == [None, None]


def test_long_augmenting_paths_do_not_recurse() -> None:
    size = 3000
    adjacency = [[left, left + 1] for left in range(size)] + [[0]]
    assert None not in maximum_matching(adjacency)
