from __future__ import annotations

import pytest

from eai.studies.prompts.study import (
    compute_average_ranks,
    compute_kendall_tau_b,
    compute_kendall_w,
    compute_variance_shares_of_rows_columns_rest,
    correct_p_values,
    count_items_best_in_both,
)


@pytest.mark.parametrize(
    ("first", "second", "tau"),
    [
        ([1, 2, 3], [10, 20, 30], 1.0),
        ([1, 2, 3], [3, 2, 1], -1.0),
        ([1, 2, 3, 4], [2, 4, 1, 3], 0.0),
        ([1, 1, 1], [1, 2, 3], None),
        ([1, 1, 2], [1, 2, 3], 2 / 6**0.5),
        ([1], [1], None),
    ],
)
def test_kendalls_tau_of_known_orders(first: list[float], second: list[float], tau: float | None) -> None:
    assert compute_kendall_tau_b(first, second) == (None if tau is None else pytest.approx(tau))


def test_tau_and_w_equal_those_of_scipy() -> None:
    stats = pytest.importorskip("scipy.stats")
    first, second = [3, 1, 4, 1, 5, 9, 2, 6], [2, 7, 1, 8, 2, 8, 1, 8]
    assert compute_kendall_tau_b(first, second) == pytest.approx(
        float(stats.kendalltau(first, second).statistic)
    )
    untied = [3, 1, 4, 2], [2, 1, 3, 4]
    rho = float(stats.spearmanr(*untied).statistic)
    assert compute_kendall_w(untied) == pytest.approx((1 + rho) / 2)


@pytest.mark.parametrize(
    ("ratings", "w"),
    [
        ([[1, 2, 3]] * 3, 1.0),
        ([[1, 2, 3], [3, 2, 1]], 0.0),
        ([[1, 1, 2], [1, 1, 2]], 1.0),
        ([[1, 1], [1, 1]], None),
        ([[1, 2]], None),
        ([], None),
    ],
)
def test_concordance_of_known_orders(ratings: list[list[float]], w: float | None) -> None:
    assert compute_kendall_w(ratings) == (None if w is None else pytest.approx(w))


def test_ranks_are_averaged_and_shared_best_items_counted() -> None:
    assert compute_average_ranks([5, 1, 5]) == [2.5, 1, 2.5]
    assert count_items_best_in_both([9, 8, 7, 1], [9, 1, 8, 7], 3) == 2
    assert count_items_best_in_both([1, 1, 1, 1], [1, 1, 1, 1], 3) == 3


def test_holms_correction_of_known_p_values() -> None:
    assert correct_p_values([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert correct_p_values([0.6, 0.9]) == pytest.approx([1.0, 1.0])
    assert correct_p_values([]) == []


def test_variance_is_split_into_rows_columns_and_rest() -> None:
    assert compute_variance_shares_of_rows_columns_rest([[1, 2], [3, 4]]) == pytest.approx((0.8, 0.2, 0.0))
    assert compute_variance_shares_of_rows_columns_rest([[1, 0], [0, 1]]) == pytest.approx((0.0, 0.0, 1.0))
    assert compute_variance_shares_of_rows_columns_rest([[5, 5], [5, 5]]) is None
