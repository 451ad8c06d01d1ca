"""How often the intervals of analyses hold the truth; ``bench/coverage.py`` does the same at length."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence

import pytest

pytest.importorskip("scipy")

from eai.results.table import Estimate
from results.near_copies import SIZES
from studies.effects import Answer, ability, answers, correlation, log_odds

SAMPLES = 100
PROMISED = 0.93


@pytest.mark.parametrize("estimate", [log_odds, correlation, ability])
def test_intervals_of_effects_hold_the_truth(estimate: Callable[[Sequence[Answer]], Estimate]) -> None:
    """Of 26 names of VirtualHome's sizes; the truth is that of many tasks of as many names."""
    truth = estimate(answers(random.Random("effects"), [1] * 6000)).value
    assert truth is not None
    generator = random.Random("effects/26 names")
    found = [estimate(answers(generator, SIZES)) for _ in range(SAMPLES)]
    held = sum(e.low is not None and e.high is not None and e.low <= truth <= e.high for e in found)
    assert held / SAMPLES >= PROMISED
