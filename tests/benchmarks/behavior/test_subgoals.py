from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.behavior.kitchen import make_task
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory
from eai.abilities.verdict import Verdict
from eai.logic.formula import Atom, Constant
from eai.tasks.share import Share
from eai.tasks.task import Goal, GoalKind
from eai.world.fault import FaultKind
from subgoal_scorers import behavior_subgoals
from sweeps import examples
from threading_tests import asked_by_threads

TASK = make_task()
STRICT = behavior_subgoals()(TASK)
REACHED = (
    "open(fridge.1)",
    "inside(peach.1, saucepan.1)",
    "holds_rh(rag.1)",
    "not dusty(plate.1) and not dusty(plate.2)",
)
EITHER = "holds_rh(plate.1) or holds_rh(rag.1)"


@pytest.fixture
def scorer() -> SubgoalDecompositionScorer:
    """Return the scorer under `strict`. Tests of other protocols override this fixture."""
    return STRICT


def answer(*subgoals: object) -> str:
    return json.dumps({"output": subgoals})


def describe_verdict(verdict: Verdict) -> str:
    """Return category and error; for runtime errors also the step."""
    assert verdict.category is not None
    error = "" if verdict.error is None else f" {verdict.error.kind.value}"
    runs = verdict.category is SubgoalAnswerCategory.RUNTIME
    step = f" {verdict.error.step}" if verdict.error is not None and runs else ""
    return f"{verdict.category.value}{error}{step}"


OUTCOMES = [
        (REACHED, "correct"),
        ([" then ".join(REACHED)], "runtime missing_step 0"),
        (REACHED[:2], "goal_unreachable"),
        ([], "goal_unreachable"),
        (["inside(peach.1, saucepan.1)"], "runtime missing_step 0"),
        (["open(fridge.1)", "open(fridge.1)"], "goal_unreachable"),
        (["holds_rh(car.1)"], "runtime affordance 0"),
        # Names.
        (["flies(rag.1)"], "hallucination hallucination"),
        (["open(rag.7)"], "hallucination hallucination"),
        (["open(rag.1, rag.10)"], "hallucination argument_number"),
        (["open()"], "hallucination argument_number"),
        (["burn(rag.1)"], "hallucination hallucination"),
        (["rag_n_01(rag.1)"], "goal_unreachable"),
        (["open(rag_1)"], "runtime affordance 0"),
        (["holds_rh(peach_1_part.0)"], "runtime missing_step 0"),
        # Syntax.
        (["open(fridge.1"], "not_parseable parsing"),
        (["not not open(fridge.1)"], "goal_unreachable"),
        (["not (open(fridge.1) and open(carton.1))"], "goal_unreachable"),
        (["forall(x, open(x))"], "not_parseable parsing"),
        (["onfloor(agent_n_01.1, room_floor_kitchen.0)"], "goal_unreachable"),
        ([7], "not_parseable parsing"),
        # Conditions that no action achieves.
        (["stained(fridge.1)"], "runtime missing_step 0"),
        (["dusty(plate.1)", "isInKitchen(rag.1)"], "goal_unreachable"),
        (["inHandOfRobot(rag.1)"], "goal_unreachable"),
        (["inHandOfRobot(rag.1) and holds_rh(rag.1)"], "goal_unreachable"),
        (["inHandOfRobot(rag.1) then holds_rh(rag.1)"], "goal_unreachable"),
        (["not (holds_rh(plate.1) or not inHandOfRobot(rag.1) or not holds_rh(rag.1))"],
         "goal_unreachable"),
        (["close(fridge.1)"], "goal_unreachable"),
        (["left_grasp(rag.1)", "inHandOfRobot(rag.1)"], "goal_unreachable"),
        # Alternatives.
        ([*REACHED[:2], EITHER, REACHED[3]], "correct"),
        (["(open(fridge.1) or open(carton.1))"], "goal_unreachable"),
    ]  # fmt: skip


@pytest.mark.parametrize(("subgoals", "outcome"), OUTCOMES)
def test_an_answer_has_its_category_and_error(subgoals: list[object], outcome: str) -> None:
    assert describe_verdict(STRICT.score(answer(*subgoals))) == outcome


def get_actions(scorer: SubgoalDecompositionScorer, *subgoals: str) -> list[str]:
    """Return the actions into which subgoals are translated."""
    return [f"{step.action}" for step in scorer.explain(answer(*subgoals)).steps]


@pytest.mark.parametrize(
    ("subgoals", "actions"),
    [
        (["ontop(rag.1, table.1)"], ["LEFT_GRASP(rag_1)", "LEFT_PLACE_ONTOP(table_1)"]),
        (["under(rag.1, plate.1)"], ["LEFT_GRASP(rag_1)", "LEFT_PLACE_UNDER(plate_1)"]),
        (["not inside(rag.1, sink.1)"], []),
        (["onfloor(rag.1, table.1)"], []),
        # A subgoal is reached once, with any free hand.
        (
            ["ontop(rag.1, table.1) and nextto(plate.1, rag.1)"],
            ["LEFT_GRASP(rag_1)", "LEFT_PLACE_NEXTTO(plate_1)"],
        ),
        (
            ["holds_rh(rag.1)", "ontop(plate.1, sink.1)"],
            ["RIGHT_GRASP(rag_1)", "LEFT_GRASP(plate_1)", "LEFT_PLACE_ONTOP(sink_1)"],
        ),
        (
            ["holds_rh(rag.1) and holds_lh(plate.1)", "open(fridge.1)"],
            ["RIGHT_GRASP(rag_1)", "LEFT_GRASP(plate_1)", "LEFT_RELEASE(plate_1)", "OPEN(fridge_1)"],
        ),
        # Subgoals that need several changes.
        (["inside(rag.1, fridge.1)"], ["LEFT_GRASP(rag_1)", "LEFT_PLACE_INSIDE(fridge_1)"]),
        (["holds_rh(rag.1) and not holds_rh(rag.1)"], []),
    ],
)  # fmt: skip
def test_subgoals_are_translated_into_their_actions(subgoals: list[str], actions: list[str]) -> None:
    assert get_actions(STRICT, *subgoals) == actions


def test_a_quantifier_is_a_parsing_error_because_the_prompt_excludes_it() -> None:
    verdict = STRICT.score(answer(*REACHED, "forall(rag_n_01, inside(rag_n_01, sink.1))"))
    assert verdict.error is not None
    assert (verdict.error.kind, verdict.error.step) == (FaultKind.PARSING, len(REACHED))


@pytest.mark.parametrize(
    "robot", ["onfloor(agent_n_01.1, room_floor_kitchen.0)", "not holds_rh(agent_n_01.1)"]
)
def test_literals_about_the_robot_count_as_true(robot: str) -> None:
    assert describe_verdict(STRICT.score(answer(*REACHED, robot))) == "correct"
    assert (
        describe_verdict(STRICT.score(answer(robot, f"{REACHED[0]} and {robot}", *REACHED[1:]))) == "correct"
    )


def test_an_entry_that_is_not_a_formula_is_a_parsing_error() -> None:
    verdict = STRICT.score(answer("or", *REACHED))
    assert verdict.error is not None
    assert (verdict.error.kind, verdict.error.step) == (FaultKind.PARSING, 0)


def test_a_verdict_lists_errors_and_satisfied_goals() -> None:
    verdict = STRICT.score(answer("open(carton.1)", *REACHED))
    assert (describe_verdict(verdict), verdict.additional_steps) == ("correct", 1)
    assert verdict.errors == (FaultKind.ADDITIONAL_STEP,)
    assert verdict.goals_satisfied == (True, True)
    rejected = STRICT.score("?")
    assert (rejected.goals_satisfied, rejected.errors) == ((False, False), ())


DUSTY = Goal(GoalKind.STATE, Atom("dusty", (Constant("plate_1"),)))
"""A goal that holds at the start."""

NOT_EXECUTED = ("?", answer("flies(rag.1)"))


def test_an_answer_that_is_not_executed_meets_no_goal() -> None:
    task = replace(TASK, goals=(DUSTY,))
    for text in NOT_EXECUTED:
        goals = behavior_subgoals()(task).score(text).goals
        assert goals is not None
        assert goals.state == Share(0, 1)


def test_an_explanation_shows_subgoals_and_the_failure() -> None:
    notes = STRICT.explain(answer("holds_rh(peach.1)")).notes
    assert notes[0] == "runtime"
    assert notes[1] == "subgoal 1: holds_rh(peach.1)"
    closed = "subgoal 1 fails: missing_step, peach_1 is inside something that is closed: fridge_1"
    assert notes[2] == closed
    too_far = STRICT.explain(answer("inside(peach.1, saucepan.1)")).notes
    assert too_far[2].startswith("subgoal 1 fails: missing_step, it takes more than 2 actions")
    assert STRICT.explain("?").notes[0] == "not_parseable"


@pytest.mark.parametrize(
    ("subgoal", "excluded"),
    [
        ("holds_rh(rag.1) and onfloor(rag.1, room_floor_kitchen.0)", True),
        ("holds_rh(peach.1) and inside(peach.1, fridge.1)", False),  # its halves may be inside
        ("holds_rh(rag.1) and inside(rag.1, sink.1)", True),
        ("holds_rh(rag.1) and holds_lh(rag.1)", True),
        ("holds_rh(rag.1) and holds_rh(peach.1)", True),
        ("holds_rh(rag.1) and holds_lh(peach.1)", False),
    ],
)
def test_a_subgoal_with_contradictory_parts_has_its_own_error(subgoal: str, excluded: bool) -> None:
    """The error names no action of the failed search, and no action is taken."""
    error = STRICT.score(answer(subgoal)).error
    assert (error is not None and error.check == "parts_exclude_each_other") is excluded
    if excluded:
        assert error is not None
        assert (error.kind.value, error.detail) == (
            "missing_step",
            f"{subgoal} does not hold, and its parts exclude each other",
        )
        assert not STRICT.explain(answer(subgoal)).steps


def test_an_error_names_no_action_that_achieves_nothing_new() -> None:
    """Every object can be put at its place; no plan needs to put an object next to itself."""
    subgoal = "ontop(carton.1, sink.1) and ontop(plate.2, rag.10) and ontop(rag.1, table.1)"
    error = STRICT.score(answer(subgoal)).error
    assert error is not None
    assert error.check == "too_many_actions"


SCRAPS = st.sampled_from(
    [
        "open(fridge.1)",
        "not",
        "and",
        "or",
        "then",
        "(",
        ")",
        "inside(rag.1, sink.1)",
        "holds_rh(rag.1)",
        "x",
        "open()",
    ]
)
TEXTS = st.one_of(
    st.text(max_size=40),
    st.lists(st.lists(SCRAPS, max_size=6).map(" ".join), max_size=4).map(lambda s: answer(*s)),
)


@settings(max_examples=examples(150), deadline=None)
@given(TEXTS)
def test_any_text_has_a_verdict_and_an_explanation(text: str) -> None:
    assert STRICT.score(text) == STRICT.score(text)
    STRICT.explain(text)


def test_many_threads_may_use_one_scorer(scorer: SubgoalDecompositionScorer) -> None:
    answers = [answer(*subgoals) for subgoals in (REACHED, REACHED[:2], [EITHER], ["stained(fridge.1)"])]
    expected = [scorer.score(text) for text in answers]
    assert asked_by_threads(lambda i: scorer.score(answers[i % 4]) == expected[i % 4], 1_500)
