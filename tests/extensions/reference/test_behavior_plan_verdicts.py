"""Verdicts on plans in BEHAVIOR: those that are of `strict`, and those that are not."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from benchmarks.behavior.test_plans import (
    GOAL_REACHED,
    HOLDS_AT_START,
    NEVER_RUN,
    OUTCOMES,
    TASK,
    TEXTS,
    answer,
    describe_outcome,
    test_an_explanation_shows_every_step_and_goal,
)
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.extensions.reference import behavior_quirks
from eai.extensions.reference.behavior_plans import BehaviorActionSequencingScorer
from eai.results.codec import verdict_to_record_fields
from sweeps import examples

REFERENCE = BehaviorActionSequencingScorer(TASK)
SHARED = (test_an_explanation_shows_every_step_and_goal,)
"""Tests of `strict` that are run again with the fixture `scorer` below."""

OTHERWISE = {
    answer(GOAL_REACHED[0].lower(), *GOAL_REACHED[1:]): "hallucination 0",
    answer("BURN peach_1"): "uncategorised 0",
}
"""Outcomes that are not those of `strict`."""

STEPS = st.tuples(
    st.sampled_from(sorted(REFERENCE.domain.compiled_operators)), st.sampled_from(sorted(TASK.scene.index))
)


@pytest.fixture
def scorer() -> ActionSequencingScorer:
    return REFERENCE


@pytest.mark.parametrize(("steps", "strict"), OUTCOMES)
def test_verdicts(steps: list[str], strict: str) -> None:
    text = answer(*steps)
    assert describe_outcome(REFERENCE.score(text)) == OTHERWISE.get(text, strict)


def test_a_plan_that_fails_after_reaching_the_goal_succeeds() -> None:
    verdict = REFERENCE.score(answer(*GOAL_REACHED, "COOK plate_1"))
    assert (describe_outcome(verdict), verdict.success) == ("affordance 6", True)


def test_partial_success_counts_the_state_that_an_aborted_action_leaves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    text = answer(*GOAL_REACHED, "BURN peach_1")
    left = REFERENCE.score(text).partial
    monkeypatch.setattr(
        behavior_quirks, "find_state_left_by_aborted_action", lambda state, action: TASK.initial
    )
    assert REFERENCE.score(text).partial != left


@pytest.mark.parametrize("text", NEVER_RUN)
def test_an_answer_that_never_ran_meets_goals_that_hold_at_the_start(text: str) -> None:
    verdict = BehaviorActionSequencingScorer(make_task(HOLDS_AT_START)).score(text)
    assert verdict.executable is False
    assert verdict_to_record_fields(verdict)["goals_satisfied"] == [True, False]


@settings(max_examples=examples(200), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert REFERENCE.score(text) == REFERENCE.score(text)
    REFERENCE.explain(text)


@settings(max_examples=examples(200), deadline=None)
@given(st.lists(STEPS, max_size=12))
def test_any_plan_has_a_verdict(steps: list[tuple[str, str]]) -> None:
    verdict = REFERENCE.score(answer(*(" ".join(step) for step in steps)) if steps else "[]")
    assert verdict.executable is (verdict.error is None)


def test_what_the_reference_passes_over_is_told() -> None:
    text = '[{"action": "OPEN", "object": "fridge_1"}, {"action": "CLEAN"}]'
    assert REFERENCE.explain(text).notes == (
        "lossy_reading: what is no step is passed over; steps that are seen: 1",
        "strict, which passes over nothing: parsing, there is no list of steps with an action and an "
        'object: step 2 has no "object"',
    )
