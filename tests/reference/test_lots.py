"""Lots: what the reference draws."""

from __future__ import annotations

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from eai.reference.lots import SEED, Lots


@given(st.lists(st.integers(1, 4).map(range), max_size=12))
def test_lots_fall_as_if_each_draw_were_made_at_once(draws: list[range]) -> None:
    lots, random = Lots(), Random(SEED)
    assert [lots.choice(options) for options in draws] == [random.choice(options) for options in draws]
