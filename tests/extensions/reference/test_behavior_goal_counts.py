"""Counts of goals in BEHAVIOR: those that are of `strict`, and those that are not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings

from benchmarks.behavior.test_goal_notation import (
    COUNTS,
    TASK,
    TEXTS,
    answer,
    counts,
    test_written_goals_score_in_full,
)
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.scorer import Scorer
from eai.abilities.verdict import ConfusionCounts
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.extensions.reference.behavior_goals import BehaviorGoalInterpretationScorer
from sweeps import examples

REFERENCE = BehaviorGoalInterpretationScorer(TASK)
SHARED = (test_written_goals_score_in_full,)
"""A test of `strict` that is run again with the fixture `scorer_of` below."""

OTHERWISE = {
    answer(["nextto", "rag.n.01_10", "rag.n.01_1"]): ((0, 0, 2), (0, 1, 2)),
    answer(*[["open", "fridge.n.01_1"]] * 2): ((0, 2, 2), (0, 0, 2)),
    answer(["open", "moon.n.01_1"]): ((0, 1, 2), (0, 0, 2)),
    answer(["open"]): ((0, 1, 2), (0, 0, 2)),
}
"""Counts that differ from `strict`. Conditions with unknown objects or missing objects count as wrong."""


@pytest.fixture
def scorer_of() -> Callable[[BehaviorTask], Scorer]:
    return BehaviorGoalInterpretationScorer


@pytest.mark.parametrize(("conditions", "strict"), COUNTS)
def test_counts(conditions: list[Any], strict: Any) -> None:
    text = answer(*conditions)
    expected = OTHERWISE.get(text, strict)
    assert counts(REFERENCE.score(text)) == tuple(ConfusionCounts(*each) for each in expected)


@pytest.mark.parametrize(
    ("text", "is_read", "aborts"),
    [
        ("", False, False),
        ("{}", True, False),
        ('{"a": {"node goals": [["open", "fridge.n.01_1"]]}}', True, False),
        ('{"node goals": {"open": "fridge.n.01_1"}}', True, False),
        ('{"node goals": null}', False, True),
        ('{"node goals": [[]]}', False, True),
        ('{"node goals": [["not"]]}', False, True),
        ('{"node goals": [7]}', False, True),
        ('{"node goals": "ab"}', True, False),
    ],
)
def test_what_can_be_read(text: str, is_read: bool, aborts: bool) -> None:
    verdict = REFERENCE.score(text)
    assert (verdict.error is None) is is_read
    assert isinstance(verdict, GoalVerdict)
    assert verdict.aborts is aborts


@settings(max_examples=examples(200), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert REFERENCE.score(text) == REFERENCE.score(text)
    REFERENCE.explain(text)
