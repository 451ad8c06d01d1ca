from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from benchmarks.plan_scorers import behavior_scorer
from eai.abilities.action_sequencing.scorer import ActionSequencingScorer
from eai.abilities.verdict import Verdict
from eai.results.codec import verdict_to_record_fields
from sweeps import examples

TASK = make_task()
STRICT = behavior_scorer(TASK)
GOAL_REACHED = (
    "OPEN fridge_1",
    "RIGHT_GRASP peach_1",
    "RIGHT_PLACE_INSIDE saucepan_1",
    "RIGHT_GRASP rag_1",
    "CLEAN plate_1",
    "CLEAN plate_2",
)


@pytest.fixture
def scorer() -> ActionSequencingScorer:
    """Return the scorer under `strict`. Tests of other protocols override this fixture."""
    return STRICT


def answer(*steps: str) -> str:
    """Return an answer with steps such as ``OPEN fridge_1``."""
    words = (step.split(" ", 1) for step in steps)
    return json.dumps([{"action": action, "object": names} for action, names in words])


def describe_outcome(verdict: Verdict) -> str:
    """Return the kind and step of the error, or whether the goals were reached."""
    if verdict.error is None:
        return "success" if verdict.success else "failure"
    step = "" if verdict.error.step is None else f" {verdict.error.step}"
    return verdict.error.kind.value + step


OUTCOMES = [
    (GOAL_REACHED, "success"),
    (GOAL_REACHED[:4], "failure"),
    (["OPEN peach_1", "OPEN nothing_1"], "hallucination 1"),
    (["oPEN fridge_1"], "hallucination 0"),
    (["open nothing_1", *GOAL_REACHED], "hallucination 0"),
    ([GOAL_REACHED[0].lower(), *GOAL_REACHED[1:]], "success"),
    (["OPEN agent.n.01_1"], "hallucination 0"),
    (["BURN peach_1"], "hallucination 0"),
    (["OPEN fridge_1, rag_1", "OPEN nothing_1"], "hallucination 1"),
    (["OPEN fridge_1, rag_1"], "argument_number 0"),
    (["LEFT_PLACE_NEXTTO_ONTOP rag_1"], "argument_number 0"),
    (["RIGHT_GRASP peach_1", "OPEN fridge_1"], "missing_step 0"),
    (["OPEN carton_1", "OPEN fridge_1", "OPEN carton_1"], "failure"),
]


@pytest.mark.parametrize(("steps", "outcome"), OUTCOMES)
def test_an_answer_has_its_expected_outcome(steps: list[str], outcome: str) -> None:
    assert describe_outcome(STRICT.score(answer(*steps))) == outcome


def test_a_plan_that_fails_after_reaching_the_goal_fails() -> None:
    verdict = STRICT.score(answer(*GOAL_REACHED, "COOK plate_1"))
    assert (describe_outcome(verdict), verdict.success) == ("affordance 6", False)


NEVER_RUN = ("nothing to do", answer("FLY fridge_1"), answer("OPEN rag_1, rag_10"))
HOLDS_AT_START = "(and (inside peach.n.01_1 fridge.n.01_1) (open fridge.n.01_1))"
"""Two goals; the first holds initially."""


def test_a_verdict_counts_goals_singly_and_by_kind() -> None:
    fields = verdict_to_record_fields(STRICT.score(answer(*GOAL_REACHED[:3])))
    assert fields["goals_satisfied"] == [True, False]
    assert fields["goals"] == {"state": [0, 1], "relation": [1, 1], "action": [0, 0]}


@pytest.mark.parametrize("text", NEVER_RUN)
def test_an_answer_that_never_runs_meets_no_goal(text: str) -> None:
    verdict = behavior_scorer(make_task(HOLDS_AT_START)).score(text)
    assert verdict.executable is False
    assert verdict_to_record_fields(verdict)["goals_satisfied"] == [False, False]


def test_additional_steps_are_skipped_and_counted() -> None:
    verdict = STRICT.score(answer("OPEN carton_1", "OPEN carton_1", *GOAL_REACHED))
    assert (describe_outcome(verdict), verdict.additional_steps) == ("success", 2)


def test_an_explanation_shows_every_step_and_goal(scorer: ActionSequencingScorer) -> None:
    explanation = scorer.explain(
        answer("OPEN fridge_1", "RIGHT_GRASP peach_1", "CLOSE fridge_1", "SLICE plate_1")
    )
    assert [step.outcome for step in explanation.steps][:3] == ["executed"] * 3
    assert explanation.steps[0].added == ("is_open(fridge_1)",)
    assert explanation.steps[3].reason != ""
    assert [goal.satisfied for goal in explanation.goals] == [False, False]
    assert scorer.explain("?").notes[0].startswith("parsing")
    assert scorer.explain(answer("FLY fridge_1")).notes == ("hallucination: step 1: FLY is not an action",)


def test_an_explanation_shows_the_place_of_an_object_that_no_goal_names() -> None:
    scorer = behavior_scorer(make_task("(and (open fridge.n.01_1))"))
    *_, last = scorer.explain(answer("RIGHT_GRASP detergent_1", "RIGHT_PLACE_NEXTTO sink_1")).steps
    assert {"stands_by(detergent_1, sink_1)", "stands_by(sink_1, detergent_1)"} <= {*last.added}
    assert last.hidden_changes == 0


SCRAPS = st.sampled_from(
    [
        "[",
        "]",
        "{",
        "}",
        '"action"',
        '"object"',
        ":",
        ",",
        "'",
        "#",
        "OPEN",
        "fridge_1",
        '"OPEN"',
        '"peach_1"',
        "null",
    ]
)
TEXTS = st.one_of(st.text(max_size=60), st.lists(SCRAPS, max_size=30).map(" ".join))


@settings(max_examples=examples(200), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert STRICT.score(text) == STRICT.score(text)
    STRICT.explain(text)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(sorted(STRICT.domain.compiled_operators)), st.sampled_from(sorted(TASK.scene.index))
    ),
    max_size=12,
)


@settings(max_examples=examples(200), deadline=None)
@given(STEPS)
def test_any_plan_is_executable_or_has_an_error(steps: list[tuple[str, str]]) -> None:
    text = answer(*(" ".join(step) for step in steps)) if steps else "[]"
    verdict = STRICT.score(text)
    assert verdict.executable is (verdict.error is None)


DUSTY = (
    "is_dusty(plate_1) remains: "
    "no hand holds a cleaning tool, and plate_1 is in no running sink or dishwasher"
)
STAINED = (
    "is_stained(plate_1) remains: "
    "no hand holds a soaked cleaning tool or detergent, and plate_1 is in no running sink"
)


@pytest.mark.parametrize(
    ("steps", "outcome", "reason"),
    [
        (
            ["RIGHT_GRASP rag_1", "CLEAN plate_1"],
            "executed",
            STAINED,
        ),
        (["RIGHT_GRASP rag_1", "CLEAN plate_2"], "executed", ""),
        (["RIGHT_GRASP detergent_1", "RIGHT_RELEASE detergent_1"], "executed", ""),
        (
            ["CLEAN plate_1"],
            "missing_step",
            f"{DUSTY}; {STAINED}",
        ),
        (["CLEAN peach_1"], "affordance", "peach_1 can be neither dusty nor stained"),
    ],
)
def test_an_explanation_of_cleaning_names_the_remaining_dirt(
    steps: list[str], outcome: str, reason: str
) -> None:
    last = STRICT.explain(answer(*steps)).steps[-1]
    assert (last.outcome, last.reason) == (outcome, reason)
