"""The coverage of intervals in analyses; ``bench/coverage.py`` measures it at length."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

import pytest

pytest.importorskip("scipy")

from eai.results.table import Estimate
from results.near_copies import SIZES
from studies.effects import Answer, answers, correlation, log_odds

SAMPLES = 100
PROMISED = 0.93


def must_hold_the_truth(estimate: Callable[[Sequence[Answer]], Estimate]) -> None:
    """Fail unless intervals of 26 names hold the estimate from 6,000 tasks of as many names."""
    truth = estimate(answers(random.Random("effects"), [1] * 6000)).value
    assert truth is not None
    generator = random.Random("effects/26 names")
    found = [estimate(answers(generator, SIZES)) for _ in range(SAMPLES)]
    held = sum(e.low is not None and e.high is not None and e.low <= truth <= e.high for e in found)
    assert held / SAMPLES >= PROMISED


@pytest.mark.parametrize("estimate", [log_odds, correlation])
def test_intervals_of_effects_hold_the_truth(estimate: Callable[[Sequence[Answer]], Estimate]) -> None:
    must_hold_the_truth(estimate)
