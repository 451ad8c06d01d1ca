from __future__ import annotations

import os
import subprocess
import sys

import pytest

np = pytest.importorskip("numpy")

from eai.extensions.adaptive.rasch import (  # noqa: E402
    compute_item_rest_correlations,
    estimate_ability_variance_between_task_groups,
    estimate_reliability,
    fit_rasch,
)

SCORES = np.array(
    [
        [1, 1, 1, 1, 0, 0],
        [1, 1, 1, 0, 0, 0],
        [1, 1, 0, 0, 0, 1],
        [1, 0, 0, 0, 0, 1],
    ],
    dtype=float,
)


def test_the_fit_is_a_maximum_of_the_posterior() -> None:
    """There every score is, up to its prior, the sum of its chances (abilities: 1, difficulties: 1/4)."""
    fitted = fit_rasch(SCORES)
    left = SCORES - fitted.predict_success()
    assert left.sum(axis=1) == pytest.approx(fitted.abilities, abs=1e-6)
    assert left.sum(axis=0) == pytest.approx(-fitted.difficulties / 4, abs=1e-6)


def test_abler_models_solve_more_and_fewer_models_solve_difficult_tasks() -> None:
    fitted = fit_rasch(SCORES)
    assert fitted.abilities[0] > fitted.abilities[1] == pytest.approx(fitted.abilities[2])
    assert list(np.argsort(fitted.difficulties)[[0, -1]]) == [0, 4]


def test_variance_between_names_is_separated_from_chance() -> None:
    """Twelve names of ten tasks; a model's ability differs by name with variance 1, or not at all."""
    draw = np.random.default_rng(5)
    names = [str(task // 10) for task in range(120)]
    difficulties, abilities = draw.normal(size=120), draw.normal(size=(20, 1))
    by_name = np.repeat(draw.normal(size=(20, 12)), 10, axis=1)
    found = []
    for spread in (0.0, 1.0):
        chances = 1 / (1 + np.exp(difficulties - abilities - spread * by_name))
        scores = (draw.random(chances.shape) < chances).astype(float)
        scores[0, 0] = np.nan
        found.append(estimate_ability_variance_between_task_groups(scores, fit_rasch(scores), names))
    assert found[0] < 0.1
    assert 0.6 < found[1] < 1.4
    assert estimate_ability_variance_between_task_groups(SCORES, fit_rasch(SCORES), list("abcdef")) == 0


def test_gaps_are_left_out() -> None:
    gaps = SCORES.copy()
    gaps[0, 0] = np.nan
    assert fit_rasch(gaps).abilities[0] < fit_rasch(SCORES).abilities[0]


def test_a_task_that_worse_models_solve_disagrees_with_the_others() -> None:
    found = compute_item_rest_correlations(SCORES)
    assert np.isnan(found[0])
    assert found[3] > 0 > found[5]
    assert found[1] == pytest.approx(np.corrcoef(SCORES[:, 1], SCORES.sum(axis=1) - SCORES[:, 1])[0, 1])


def test_equal_scores_have_no_correlation_despite_rounding_errors() -> None:
    equal_task = np.array([[0.1, 0, 1], [0.1, 1, 1], [0.1, 1, 0]])
    assert np.isnan(compute_item_rest_correlations(equal_task)[0])
    equal_totals = np.array([[0.1, 0.2, 0], [0.3, 0, 1], [0.15, 0.15, 0]])
    assert np.isnan(compute_item_rest_correlations(equal_totals)[2])
    assert estimate_reliability(equal_totals[:, :2]) is None


def test_variance_does_not_depend_on_the_order_of_names_in_a_set() -> None:
    program = (
        "import numpy as np\n"
        "from eai.extensions.adaptive.rasch import *\n"
        "ability = np.random.default_rng(1).normal(0, 2, (9, 60))\n"
        "scores = np.tile(ability > 0, 5).astype(float)\n"
        "names = [f'n{number % 60}' for number in range(300)]\n"
        "print(estimate_ability_variance_between_task_groups(scores, fit_rasch(scores), names))\n"
    )
    printed = {
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
        ).stdout
        for seed in "1234"
    }
    assert len(printed) == 1


def test_alpha_is_cronbachs() -> None:
    variances, whole = SCORES.var(axis=0, ddof=1).sum(), SCORES.sum(axis=1).var(ddof=1)
    assert estimate_reliability(SCORES) == pytest.approx(6 / 5 * (1 - variances / whole))
    assert estimate_reliability(np.ones((3, 2))) is None
