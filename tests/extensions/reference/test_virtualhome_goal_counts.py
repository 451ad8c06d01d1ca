"""Counts of goals in VirtualHome: those that are of `strict`, and those that are not."""

from __future__ import annotations

import pytest
from hypothesis import given

from benchmarks.virtualhome.test_goal_notation import (
    COUNTS,
    DOMAIN,
    IGNORED_ENTRIES,
    ON_BED,
    OPEN,
    TASK,
    TEXTS,
    UNKNOWN_NAMES,
    answer,
    assert_has_a_verdict,
    counts,
    get_wrong_goals,
    test_an_unreadable_answer_is_a_parsing_error,
    test_extreme_texts_have_a_verdict,
)
from eai.abilities.goal_interpretation.verdict import GoalVerdict
from eai.abilities.scorer import Scorer
from eai.extensions.reference.virtualhome_goals import VirtualHomeGoalInterpretationScorer

REFERENCE = VirtualHomeGoalInterpretationScorer(TASK, DOMAIN)
SHARED = (test_extreme_texts_have_a_verdict, test_an_unreadable_answer_is_a_parsing_error)
"""Tests of `strict` that are run again with the fixture `scorer` below."""

OTHERWISE = {
    answer([OPEN], [ON_BED, ON_BED], ["WATCH", "TYPE"]): [(1, 0, 0), (1, 0, 1), (2, 0, 0)],
    answer(relations=[ON_BED] * 3): [(0, 0, 1), (1, 0, 1), (0, 0, 2)],
    answer([{"name": "fridge", "state": "SHINY"}], [{**ON_BED, "relation": "UNDER"}]): [
        (0, 1, 1),
        (0, 1, 2),
        (0, 0, 2),
    ],
    answer(actions=["watch", "LOOKAT", "FLY"]): [(0, 0, 1), (0, 0, 2), (2, 1, 0)],
    answer(actions=[{"action": "TYPE", "description": d} for d in "abc"]): [(0, 0, 1), (0, 0, 2), (3, 0, -1)],
    "The fridge should be open.": [(0, 0, 0)] * 3,
    "Sure! " + answer([OPEN]): [(0, 0, 0)] * 3,
    answer([OPEN]) + "}": [(0, 0, 0)] * 3,
    '{"node goals": null}': [(0, 0, 0)] * 3,
}
"""Counts that differ from `strict`.

Of two cups on the bed the one with the largest id counts. Unknown words are wrong. An action goal is met as
often as it is said. What cannot be read misses nothing.
"""


@pytest.fixture
def scorer() -> Scorer:
    return REFERENCE


@pytest.mark.parametrize(("text", "strict"), COUNTS)
def test_the_counts(text: str, strict: list[object]) -> None:
    assert counts(REFERENCE.score(text)) == tuple(OTHERWISE.get(text, strict))


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "3",
        '{"node goals": null}',
        '{"node goals": [3]}',
        '{"node goals": [{"name": [], "state": "ON"}]}',
        '{"action goals": [{"action": 3}]}',
        '{"edge goals": [["from_name", "relation", "to_name"]]}',
    ],
)
def test_an_answer_on_which_the_reference_aborts_is_told(text: str) -> None:
    verdict = REFERENCE.score(text)
    assert isinstance(verdict, GoalVerdict)
    assert verdict.aborts is True


def test_only_objects_that_do_not_exist_are_reported() -> None:
    verdict = REFERENCE.score(UNKNOWN_NAMES)
    assert isinstance(verdict, GoalVerdict)
    assert verdict.hallucinated == ("yacht", "moon")


def test_an_explanation_says_which_goals_are_met() -> None:
    explanation = REFERENCE.explain(answer([OPEN], [ON_BED], ["LOOKAT"]))
    assert [goal.satisfied for goal in explanation.goals] == [True, False, True, True, False]


def test_an_explanation_says_what_is_left_out() -> None:
    notes = REFERENCE.explain(IGNORED_ENTRIES).notes
    assert notes[:2] == (
        "left out as ill-formed: {'name': 'cup'}",
        "left out as hallucination: there is no yacht",
    )
    assert "wrong: SHINY(fridge.10)" in notes


def test_explanations_name_each_wrong_goal_once() -> None:
    assert get_wrong_goals(REFERENCE) == ["CLOSED(fridge.10)", "UNDER(cup.40, bed.20)", "FLY"]


@given(TEXTS)
def test_any_text_has_a_verdict(text: str) -> None:
    assert_has_a_verdict(REFERENCE, text)
