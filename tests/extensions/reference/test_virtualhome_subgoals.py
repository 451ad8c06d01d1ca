"""Verdicts on subgoals in VirtualHome: those that are of `strict`, and those that are not."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from benchmarks.virtualhome.test_subgoals import (
    ANY_TEXT,
    CUP_HELD,
    OUTCOMES,
    POURED,
    REACHED,
    TASK,
    TEXTS,
    THREE_ACTIONS,
    WITHOUT_GOALS,
    answer,
    assert_has_a_verdict,
    describe_verdict,
    test_extreme_subgoals_have_a_verdict,
    test_many_threads_may_use_one_scorer,
)
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.extensions.reference.virtualhome_subgoals import VirtualHomeSubgoalDecompositionScorer
from eai.tasks.share import Share
from eai.tasks.task import Task
from eai.world.fault import FaultKind

REFERENCE = VirtualHomeSubgoalDecompositionScorer(TASK)
SHARED = (test_many_threads_may_use_one_scorer, test_extreme_subgoals_have_a_verdict)
"""Tests of `strict` that are run again with the fixture `scorer` below."""

BY_LOT = {
    answer("OPEN(table.12) or TOUCH(table.12)", *REACHED[1:]),
    answer(*REACHED[:3], "not (CLOSED(fridge.10) or not ONTOP(cup.13, bed.20))"),
}
"""Answers that are split at alternatives, one of which is drawn."""

OTHERWISE = {
    answer(" then ".join(REACHED)): "correct",
    answer(f"({' and '.join(REACHED)})"): "correct",
    answer(): "not_parseable parsing",
    answer("POUR(milk.11, cup.13)"): "hallucination hallucination",
    answer(
        "(OPEN(table.12) or TOUCH(table.12)) and SITTING(character.65)", *REACHED[1:]
    ): "not_parseable parsing",
    answer("exists x. (TOUCH(x))", *REACHED[1:]): "not_parseable parsing",
    answer(*REACHED, "not CLOSED(fridge.10)"): "not_parseable parsing",
    answer("not CLOSED(fridge.10)"): "not_parseable parsing",
    answer("TOUCH(table)", "OPEN(fridge)", CUP_HELD, "ONTOP(cup.13, bed)"): "not_parseable parsing",
    answer("TOUCH(table)", "OPEN(fridge)", CUP_HELD, "ONTOP(cup, bed)"): "not_parseable parsing",
    answer(*REACHED, "forall x. (not HOLDS_RH(character.65, x))"): "not_parseable parsing",
    answer(*REACHED, "CLOSED(fridge.10)"): "correct",
    answer(*REACHED).replace('"', "'"): "not_parseable parsing",
    "{" + answer(*REACHED)[1:-1] + ', "more": ["a"]}': "correct",
    answer("I will open it.", *REACHED): "correct",
}
"""Outcomes that are not those of `strict`."""


@pytest.fixture
def scorer() -> SubgoalDecompositionScorer:
    return REFERENCE


@pytest.mark.parametrize(
    ("text", "strict"),
    [*((answer(*subgoals), outcome) for subgoals, outcome in OUTCOMES), *TEXTS],
)
def test_the_category_and_the_error(text: str, strict: str) -> None:
    if text not in BY_LOT:
        assert describe_verdict(REFERENCE.score(text)) == OTHERWISE.get(text, strict)


def test_the_reference_counts_entries_but_not_those_of_unreachable_goals() -> None:
    twice = ("OPEN(fridge.10)", "OPEN(fridge.10)")
    failed = REFERENCE.score(answer(*twice, "HOLDS_RH(character.65, table.12)"))
    assert failed.counted is not None
    assert failed.counted.errors == {FaultKind.AFFORDANCE: 1, FaultKind.ADDITIONAL_STEP: 1}
    missed, reached = (REFERENCE.score(answer(*subgoals)) for subgoals in (twice, (*REACHED[:1], *REACHED)))
    assert missed.errors == (FaultKind.ADDITIONAL_STEP,)
    assert missed.counted is not None
    assert (missed.counted.success, missed.counted.errors) == (False, {})
    assert reached.counted is not None
    assert (reached.counted.success, reached.counted.goals) == (
        True,
        reached.goals,
    )


def test_action_goals_count_up_to_the_first_that_is_missing() -> None:
    for subgoals, met in ((("PUSH(table.12)", "TOUCH(table.12)"), 1), (("PUSH(table.12)",), 0)):
        goals = VirtualHomeSubgoalDecompositionScorer(THREE_ACTIONS).score(answer(*subgoals)).goals
        assert goals is not None
        assert goals.action == Share(met, 3)


@pytest.mark.parametrize("task", [POURED, WITHOUT_GOALS], ids=["poured", "without goals"])
def test_a_goal_that_cannot_be_read_makes_every_plan_unparseable(task: Task) -> None:
    assert (
        describe_verdict(VirtualHomeSubgoalDecompositionScorer(task).score(answer(*REACHED)))
        == "not_parseable parsing"
    )


def test_a_negation_is_explained_as_unparseable() -> None:
    assert REFERENCE.explain(answer("not OPEN(fridge.10)")).notes[0] == "not_parseable"


@settings(deadline=None)
@given(ANY_TEXT)
def test_any_text_has_a_verdict(text: str) -> None:
    assert_has_a_verdict(REFERENCE, text)
