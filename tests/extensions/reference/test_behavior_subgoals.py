"""Verdicts on subgoals in BEHAVIOR: those that are of `strict`, and those that are not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings

from benchmarks.behavior.test_subgoals import (
    DUSTY,
    EITHER,
    NOT_EXECUTED,
    OUTCOMES,
    REACHED,
    TASK,
    TEXTS,
    answer,
    describe_verdict,
    get_actions,
    test_many_threads_may_use_one_scorer,
)
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.extensions.reference.behavior_subgoals import BehaviorSubgoalDecompositionScorer
from eai.tasks.share import Share
from sweeps import examples

REFERENCE = BehaviorSubgoalDecompositionScorer(TASK)
SHARED = (test_many_threads_may_use_one_scorer,)
"""Tests of `strict` that are run again with the fixture `scorer` below."""

OTHERWISE = {
    answer(" then ".join(REACHED)): "correct",
    answer(): "not_parseable parsing",
    answer("open()"): "not_parseable parsing",
    answer("burn(rag.1)"): "not_parseable parsing",
    answer("rag_n_01(rag.1)"): "not_parseable parsing",
    answer("open(rag_1)"): "hallucination hallucination",
    answer("holds_rh(peach_1_part.0)"): "hallucination hallucination",
    answer("not not open(fridge.1)"): "not_parseable parsing",
    answer("not (open(fridge.1) and open(carton.1))"): "not_parseable parsing",
    answer("onfloor(agent_n_01.1, room_floor_kitchen.0)"): "not_parseable parsing",
    answer("stained(fridge.1)"): "goal_unreachable",
    answer(*REACHED[:2], EITHER, REACHED[3]): "runtime missing_step 3",
    answer("(open(fridge.1) or open(carton.1))"): "not_parseable parsing",
}
"""Outcomes that differ from `strict`.

Subgoals that no action makes true are skipped, and so are actions. The first alternative is taken, with
the text that follows.
"""


@pytest.fixture
def scorer() -> SubgoalDecompositionScorer:
    return REFERENCE


@pytest.mark.parametrize(("subgoals", "strict"), OUTCOMES)
def test_verdicts(subgoals: list[object], strict: str) -> None:
    text = answer(*subgoals)
    assert describe_verdict(REFERENCE.score(text)) == OTHERWISE.get(text, strict)


@pytest.mark.parametrize(
    ("subgoals", "actions"),
    [
        (["ontop(rag.1, table.1)"], ["RIGHT_GRASP(rag_1)", "RIGHT_PLACE_ONTOP(table_1)"]),
        (["onfloor(rag.1, table.1)"], ["RIGHT_GRASP(rag_1)", "RIGHT_PLACE_ONTOP(table_1)"]),
        (["under(rag.1, plate.1)"], ["RIGHT_GRASP(rag_1)", "RIGHT_PLACE_UNDER(plate_1)"]),
        (["touching(rag.1, plate.1)"], ["RIGHT_GRASP(rag_1)", "RIGHT_PLACE_NEXTTO(plate_1)"]),
        (["not inside(rag.1, sink.1)"], ["RIGHT_GRASP(rag_1)", "RIGHT_RELEASE(rag_1)"]),
        (["holds_lh(rag.1)", "not holds_lh(rag.1)"], ["LEFT_GRASP(rag_1)", "LEFT_RELEASE(rag_1)"]),
        (["not holds_lh(rag.1)"], []),
        (["toggledon(sink.1)", "not toggledon(sink.1)"], ["TOGGLE_ON(sink_1)", "TOGGLE_OFF(sink_1)"]),
        # An object that is put onto something and next to something is placed once.
        (
            ["ontop(rag.1, table.1)", "nextto(plate.1, rag.1)"],
            ["RIGHT_GRASP(rag_1)", "RIGHT_PLACE_NEXTTO_ONTOP(plate_1, table_1)"],
        ),
        # Hands: the right one first, then the left one, then the right one is emptied.
        (
            ["holds_rh(rag.1)", "ontop(plate.1, sink.1)"],
            ["RIGHT_GRASP(rag_1)", "LEFT_GRASP(plate_1)", "LEFT_PLACE_ONTOP(sink_1)"],
        ),
        (
            ["holds_rh(rag.1) and holds_lh(plate.1)", "open(fridge.1)"],
            ["RIGHT_GRASP(rag_1)", "LEFT_GRASP(plate_1)", "RIGHT_RELEASE(rag_1)", "OPEN(fridge_1)"],
        ),
    ],
)  # fmt: skip
def test_what_the_reference_does_for_subgoals(subgoals: list[str], actions: list[str]) -> None:
    assert get_actions(REFERENCE, *subgoals) == actions


def test_a_hand_holds_what_its_content_is_named_after_in_the_reference() -> None:
    subgoals = ("holds_lh(rag.10)", "inside(rag.1, sink.1)")
    assert get_actions(REFERENCE, *subgoals)[1:] == ["LEFT_PLACE_INSIDE(sink_1)"]


def test_an_answer_that_is_not_carried_out_meets_goals_that_hold_at_the_start() -> None:
    for text in NOT_EXECUTED:
        goals = BehaviorSubgoalDecompositionScorer(replace(TASK, goals=(DUSTY,))).score(text).goals
        assert goals is not None
        assert goals.state == Share(1, 1)


@settings(max_examples=examples(150), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert REFERENCE.score(text) == REFERENCE.score(text)
    REFERENCE.explain(text)
