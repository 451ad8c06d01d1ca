from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.share import Share
from eai.metrics.bootstrap import Bootstrap

halves = st.integers(0, 40).map(lambda n: n / 2)


@given(st.lists(st.tuples(halves, halves), min_size=1, max_size=8))
def test_replicates_are_ratios_of_the_sums_of_drawn_tasks(parts: list[tuple[float, float]]) -> None:
    bootstrap = Bootstrap(seed=3, repetitions=5)
    found = bootstrap.replicates([{"x": Share(*part)} for part in parts], ["x"])["x"]
    generator = random.Random(f"3/{len(parts)}")
    for value in found:
        drawn = generator.choices(parts, k=len(parts))
        whole = sum(denominator for _, denominator in drawn)
        assert value == (
            pytest.approx(100 * sum(numerator for numerator, _ in drawn) / whole) if whole else None
        )


def test_interval_of_a_share_is_near_the_binomial_one() -> None:
    rates = [{"x": Share(int(i < 60), 1)} for i in range(100)]
    found = Bootstrap().intervals(rates, ["x"])["x"]
    assert found is not None
    assert found.low == pytest.approx(50, abs=1.5)  # the quantiles of Binomial(100, 0.6) are 50 and 69
    assert found.high == pytest.approx(69.5, abs=1.5)


def test_same_seed_same_draws_and_another_seed_others() -> None:
    rates = [{"x": Share(i % 3, 2)} for i in range(30)]
    assert Bootstrap().replicates(rates, ["x"]) == Bootstrap().replicates(rates, ["x"])
    assert Bootstrap().replicates(rates, ["x"]) != Bootstrap(seed=1).replicates(rates, ["x"])


def test_nothing_has_no_interval() -> None:
    assert Bootstrap().intervals([], ["x"]) == {"x": None}
    assert Bootstrap().intervals([{}], ["x"]) == {"x": None}
