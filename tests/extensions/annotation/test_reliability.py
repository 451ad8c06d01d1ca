from __future__ import annotations

from itertools import product
from statistics import fmean, pvariance

import pytest

from eai.extensions.annotation.study import compute_krippendorff_alpha, compute_mse_around_task_means

KRIPPENDORFF = (
    "1 2 3 3 2 1 4 1 2 . . .",
    "1 2 3 3 2 2 4 1 2 5 . 3",
    ". 3 3 3 2 3 4 2 2 5 1 .",
    "1 2 3 3 2 4 4 1 2 5 1 .",
)
"""Four observers, twelve things: the example of Krippendorff's own instructions (interval alpha .849)."""


def units(*raters: str) -> list[list[float]]:
    rows = [rater.split() for rater in raters]
    return [[float(score) for score in column if score != "."] for column in zip(*rows, strict=True)]


def test_alpha_of_krippendorffs_example() -> None:
    assert compute_krippendorff_alpha(units(*KRIPPENDORFF)) == pytest.approx(0.849, abs=5e-4)


def test_alpha_equals_its_definition() -> None:
    rated = [unit for unit in units(*KRIPPENDORFF) if len(unit) > 1]
    all_ratings = [rating for unit in rated for rating in unit]
    n = len(all_ratings)
    observed = sum(sum((a - b) ** 2 for a in unit for b in unit) / (len(unit) - 1) for unit in rated) / n
    expected = sum((a - b) ** 2 for a in all_ratings for b in all_ratings) / (n * (n - 1))
    assert compute_krippendorff_alpha(rated) == pytest.approx(1 - observed / expected)


@pytest.mark.parametrize(
    ("rated", "alpha"),
    [
        ([[1, 1], [5, 5]], 1.0),
        ([[1, 5], [5, 1]], -0.5),
        ([[3, 3], [3, 3]], None),
        ([[1], [5]], None),
        ([], None),
    ],
)
def test_alpha_of_few_ratings(rated: list[list[float]], alpha: float | None) -> None:
    assert compute_krippendorff_alpha(rated) == alpha


@pytest.mark.parametrize(
    ("rated", "mse"),
    [
        ([[1, 3], [4, 4, 4, 5]], (2 * 1 + 4 * 3 / 16) / 6),
        ([[1, 3], [5]], 1.0),
        ([[4], [5]], None),
    ],
)
def test_the_weighted_error_uses_tasks_rated_more_than_once(
    rated: list[list[float]], mse: float | None
) -> None:
    assert compute_mse_around_task_means(rated) == mse


@pytest.mark.parametrize(("sizes", "expected"), [((2,), 1.0), ((4, 2, 2), 1.25)])
def test_ratings_at_random_have_the_error_that_the_docs_say(sizes: tuple[int, ...], expected: float) -> None:
    """The mean over all ways to rate, of which each is as likely: a thing rated n times has 2 (n - 1) / n."""
    means = {n: fmean(pvariance(ways) for ways in product(range(1, 6), repeat=n)) for n in set(sizes)}
    assert sum(n * means[n] for n in sizes) / sum(sizes) == pytest.approx(expected)
