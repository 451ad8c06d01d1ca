from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from eai.abilities.verdict import (
    ConfusionCounts,
    make_confusion_shares,
    make_rate_contribution_of_answer,
    sum_confusion_counts,
)
from eai.results.rate import NOTHING, Rate, compute_rate, compute_rates
from eai.tasks.share import Share

counts = st.integers(0, 50)


def test_a_rate_without_cases_is_none_and_not_zero() -> None:
    assert (NOTHING.percent, NOTHING.share) == (None, None)
    assert Rate(1, 4).share == 0.25
    assert Rate(0, 4).percent == 0.0


def test_total_sums_numerators_and_denominators() -> None:
    assert compute_rates(
        [{"a": Share(1, 1)}, {"a": Share(0, 3), "b": make_rate_contribution_of_answer(True)}]
    ) == {
        "a": Rate(1, 4),
        "b": Rate(1, 1),
    }


@given(st.lists(st.tuples(counts, counts, counts), min_size=1))
def test_rates_do_not_depend_on_the_parts_in_which_they_are_summed(rows: list[tuple[int, int, int]]) -> None:
    confusions = [ConfusionCounts(*row) for row in rows]
    whole = {
        name: Rate(*share)
        for name, share in make_confusion_shares("x", sum_confusion_counts(confusions)).items()
    }
    assert compute_rates(make_confusion_shares("x", c) for c in confusions) == whole


@given(st.data())
def test_rates_do_not_depend_on_the_order_of_answers(data: st.DataObject) -> None:
    fractions = st.fractions(0, 1, max_denominator=30).map(float)
    shares = data.draw(
        st.lists(st.builds(Share, st.sampled_from([0.1, 0.5]) | fractions, counts), min_size=1)
    )
    permuted = data.draw(st.permutations(shares))
    rate = compute_rate(shares)
    assert compute_rate(permuted) == rate
    by_metric = compute_rates([{"a": share} for share in permuted])["a"]
    assert repr(by_metric) == repr(rate)  # 1 and 1.0 are written differently in summary.json


@given(st.integers(1, 50), counts, counts)
def test_f1_is_the_harmonic_mean(hits: int, extra: int, missed: int) -> None:
    shares = make_confusion_shares("x", ConfusionCounts(hits, extra, missed))
    precision, recall, f1 = (Rate(*shares[f"x.{name}"]).percent for name in ("precision", "recall", "f1"))
    assert precision
    assert recall
    assert f1 == pytest.approx(2 * precision * recall / (precision + recall))
