from __future__ import annotations

import platform

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.households.virtualhome.slot_order import slot_order, union_order

ids = st.lists(st.integers(0, 2100), max_size=120)
pytestmark = pytest.mark.skipif(
    platform.python_implementation() != "CPython", reason="compares with the sets of CPython"
)


@given(ids)
def test_it_is_the_order_of_a_set(values: list[int]) -> None:
    expected: set[int] = set()
    for value in values:
        expected.add(value)
    assert slot_order(values) == list(expected)


@given(ids, ids)
def test_it_is_the_order_of_a_union(values: list[int], more: list[int]) -> None:
    first: set[int] = set()
    second: set[int] = set()
    for value in values:
        first.add(value)
    for value in more:
        second.add(value)
    assert union_order(values, more) == list(first.union(second - first))


def test_collisions_decide_the_order() -> None:
    assert slot_order([8, 0]) == [8, 0]
    assert slot_order([0, 8]) == [0, 8]
