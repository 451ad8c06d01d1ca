from __future__ import annotations

import pytest
from hypothesis import given

from benchmarks.virtualhome.test_plans_robustness import (
    MADE_UP,
    TEXTS,
    assert_has_a_verdict,
    test_a_plan_of_ten_thousand_steps_is_executed,
    test_extreme_texts_have_a_verdict,
)
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.extensions.reference.virtualhome_plans import VirtualHomeActionSequencingScorer

SHARED = (test_extreme_texts_have_a_verdict, test_a_plan_of_ten_thousand_steps_is_executed)
"""Tests of `strict` that are run again with the fixture `scorer` below."""

SCORERS = [VirtualHomeActionSequencingScorer(MADE_UP, with_ids=with_ids) for with_ids in (None, True, False)]


@pytest.fixture
def scorer() -> ActionSequencingScorer:
    return SCORERS[0]


@given(TEXTS)
def test_any_text_has_a_verdict(text: str) -> None:
    for scorer in SCORERS:
        assert_has_a_verdict(scorer, text)
