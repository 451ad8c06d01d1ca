from __future__ import annotations

import math

import pytest

from eai.results.table import Estimate
from eai.studies.cofactors.effects import compute_rank_correlation, fit_logistic_regression

np = pytest.importorskip("numpy")


def bounds(effect: Estimate) -> tuple[float, float]:
    assert effect.low is not None
    assert effect.high is not None
    return effect.low, effect.high


def test_log_odds_of_two_groups_equal_those_of_their_counts() -> None:
    """Of two groups the maximum is known: 30 of 40, and 10 of 40."""
    group = [1.0] * 40 + [0.0] * 40
    success = [1.0] * 30 + [0.0] * 10 + [1.0] * 10 + [0.0] * 30
    effects = fit_logistic_regression(
        np.column_stack([group, np.ones(80)]), np.array(success), [str(number) for number in range(80)]
    )
    assert effects[0].value == pytest.approx(math.log(9))
    assert effects[1].value == pytest.approx(math.log(1 / 3))
    low, high = bounds(effects[0])
    assert low < math.log(9) < high
    half = (high - low) / 2
    assert half == pytest.approx(
        1.99 * math.sqrt(2 / 30 + 2 / 10), rel=0.05
    )  # Woolf's, by Student's quantile


def test_similar_observations_give_wider_intervals() -> None:
    group, success = [1.0] * 40 + [0.0] * 40, ([1.0] * 30 + [0.0] * 10) + ([1.0] * 10 + [0.0] * 30)
    columns = np.column_stack([group, np.ones(80)])
    alone = fit_logistic_regression(columns, np.array(success), [str(n) for n in range(80)])
    copies = fit_logistic_regression(columns, np.array(success), [str(n // 10) for n in range(80)])
    (low, high), (least, most) = bounds(copies[0]), bounds(alone[0])
    assert high - low > 2 * (most - least)


def test_a_column_that_separates_success_has_no_effect_estimate() -> None:
    columns = np.column_stack([[1.0] * 5 + [0.0] * 5, np.ones(10)])
    assert (
        fit_logistic_regression(columns, np.array([1.0] * 5 + [0.0] * 5), list("abcdefghij"))
        == [Estimate(None)] * 2
    )


def test_rank_correlation_equals_spearmans() -> None:
    found = compute_rank_correlation([1, 2, 3, 4, 5, 6], [1, 3, 2, 5, 4, 6], list("abcdef"))
    assert found.value == pytest.approx(1 - 6 * 4 / (6 * 35))
    assert found.low is not None
    assert found.high is not None
    assert -1 < found.low < (found.value or 0) < found.high < 1
    assert compute_rank_correlation([1, 1], [1, 2], ["a", "b"]).value is None
