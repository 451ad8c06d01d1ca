from __future__ import annotations

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.virtualhome.household import make_task
from eai.abilities.subgoal_decomposition.scorer import SubgoalDecompositionScorer
from eai.abilities.subgoal_decomposition.search import ExplorationLimits
from eai.abilities.subgoal_decomposition.verdict import SubgoalAnswerCategory
from eai.abilities.verdict import Verdict
from eai.results.codec import dataclass_to_json, verdict_to_record_fields
from eai.tasks.share import Share
from eai.world.fault import FaultKind
from subgoal_scorers import virtualhome_subgoals
from threading_tests import asked_by_threads

GOALS = ("state OPEN fridge.10", "relation ONTOP cup.13 bed.20", "action TOUCH|PUSH")
TASK = replace(
    make_task(goals=GOALS, more_objects=("cup.40",)),
    temporal_goal="(exists x. ((TOUCH(x) or PUSH(x))) then (OPEN(fridge.10) and ONTOP(cup.13, bed.20)))",
)
STRICT = virtualhome_subgoals()(TASK)
CUP_HELD = "HOLDS_RH(character.65, cup.13)"
REACHED = ("TOUCH(table.12)", "OPEN(fridge.10)", CUP_HELD, "ONTOP(cup.13, bed.20)")


@pytest.fixture
def scorer() -> SubgoalDecompositionScorer:
    """Return the scorer under `strict`. Tests of other protocols override this fixture."""
    return STRICT


def answer(*subgoals: object) -> str:
    return json.dumps({"necessity_to_use_action": "yes", "actions_to_include": [], "output": subgoals})


def describe_verdict(verdict: Verdict) -> str:
    """Return category and error; for runtime errors also the step."""
    assert verdict.category is not None
    error = "" if verdict.error is None else f" {verdict.error.kind.value}"
    runs = verdict.category is SubgoalAnswerCategory.RUNTIME
    step = f" {verdict.error.step}" if verdict.error is not None and runs else ""
    return f"{verdict.category.value}{error}{step}"


OUTCOMES = [
    (REACHED, "correct"),
    # An entry is one subgoal, which takes at most two actions, even if it joins several.
    ([" then ".join(REACHED)], "runtime missing_step 0"),
    ([f"({' and '.join(REACHED)})"], "runtime missing_step 0"),
    (REACHED[1:], "goal_unreachable"),
    (["HOLDS_RH(character.65, milk.11)"], "runtime missing_step 0"),
    (["OPEN(table.12)"], "runtime affordance 0"),
    ([], "goal_unreachable"),
    # Names.
    (["FLY(table.12)"], "hallucination hallucination"),
    (["OPEN(yacht.9)"], "hallucination hallucination"),
    (["OPEN(fridge.11)"], "hallucination hallucination"),
    (["OPEN(fridge.10, cup.13)"], "hallucination argument_number"),
    (["OPEN(x)"], "hallucination hallucination"),
    (["POUR(milk.11, cup.13)"], "runtime missing_step 0"),
    # Syntax.
    (["OPEN(fridge.10"], "not_parseable parsing"),
    (["OPEN(fridge.10))", "FLY(x)"], "not_parseable parsing"),
    (["eventually OPEN(fridge.10)"], "not_parseable parsing"),
    ([3], "not_parseable parsing"),
    # Alternatives: all are tried.
    (["OPEN(table.12) or TOUCH(table.12)", *REACHED[1:]], "correct"),
    (
        ["(OPEN(table.12) or TOUCH(table.12)) and SITTING(character.65)", *REACHED[1:]],
        "runtime missing_step 0",
    ),
    (["exists x. (TOUCH(x))", *REACHED[1:]], "correct"),
    # Negations.
    ([*REACHED, "not CLOSED(fridge.10)"], "correct"),
    (["not CLOSED(fridge.10)"], "goal_unreachable"),
    (
        [*REACHED[:3], "not (CLOSED(fridge.10) or not ONTOP(cup.13, bed.20))"],
        "correct",
    ),
    (["not TOUCH(table.12)"], "not_parseable parsing"),
    (["OPEN(table.12)", "not ON(fridge.10)"], "runtime affordance 0"),
    # Names without ids.
    (
        ["TOUCH(table)", "OPEN(fridge)", CUP_HELD, "ONTOP(cup.13, bed)"],
        "correct",
    ),
    (["TOUCH(table)", "OPEN(fridge)", CUP_HELD, "ONTOP(cup, bed)"], "correct"),
    # Conditions that no action achieves.
    ([*REACHED, "SITTING(character.65)"], "correct"),
    ([*REACHED, "SITTING(character.65) and ONTOP(character.65, bed.20)"], "correct"),
    ([*REACHED, "NEXT_TO(cup.13, book.16)"], "correct"),
    ([*REACHED, "NEXT_TO(cup.13, character.65)"], "correct"),
    ([*REACHED, "GRABBABLE(cup.13)"], "correct"),
    ([*REACHED, "forall x. (not HOLDS_RH(character.65, x))"], "correct"),
    ([*REACHED, "forall x. (TOUCH(x))"], "not_parseable parsing"),
    # The goal must hold at the end, or at any time.
    ([*REACHED, "CLOSED(fridge.10)"], "goal_unreachable"),
    ([*REACHED[1:], "TOUCH(table.12)"], "correct"),
]


@pytest.mark.parametrize(("subgoals", "outcome"), OUTCOMES)
def test_an_answer_has_its_category_and_error(subgoals: list[object], outcome: str) -> None:
    assert describe_verdict(STRICT.score(answer(*subgoals))) == outcome


@pytest.mark.parametrize(
    ("subgoals", "additional"),
    [
        (["GRAB(cup.13)", "GRAB(cup.13)"], 1),
        # One subgoal states each action once, however often it names the action.
        (["GRAB(cup.13) and GRAB(cup.13)"], 0),
        # A condition that holds already is an additional step ...
        (["OPEN(fridge.10)", "OPEN(fridge.10)"], 1),
        ([CUP_HELD, "GRAB(cup.13)"], 1),
        # ... unless an action of the same subgoal achieves it, or the subgoal has other conditions.
        ([f"GRAB(cup.13) and {CUP_HELD}"], 0),
        ([f"{CUP_HELD} and GRAB(cup.13)"], 0),
        (["OPEN(fridge.10)", f"OPEN(fridge.10) and {CUP_HELD}"], 0),
        (["OPEN(fridge.10)", "OPEN(fridge.10) and TOUCH(table.12)"], 0),
    ],
)
def test_subgoals_that_hold_already_are_additional_steps(subgoals: list[str], additional: int) -> None:
    verdict = STRICT.score(answer(*subgoals))
    assert (verdict.executable, verdict.additional_steps) == (True, additional)


TEXTS = [
    ("Sure:\n```json\n" + answer(*REACHED) + "\n```", "correct"),
    (answer(*REACHED).replace('"', "'"), "correct"),
    ("{" + answer(*REACHED)[1:-1] + ', "why": "so"}', "correct"),
    ("{" + answer(*REACHED)[1:-1] + ', "more": ["a"]}', "not_parseable parsing"),
    ('{"output": "OPEN(fridge.10)"}', "not_parseable parsing"),
    ("OPEN(fridge.10)", "not_parseable parsing"),
    (answer("I will open it.", *REACHED), "not_parseable parsing"),
    (answer(*REACHED, "ONTOP(character.65, bed.20)", "SLEEP"), "correct"),
]


@pytest.mark.parametrize(("text", "outcome"), TEXTS)
def test_subgoals_are_read_from_several_forms_of_answers(text: str, outcome: str) -> None:
    assert describe_verdict(STRICT.score(text)) == outcome


def test_a_verdict_under_strict_has_no_separate_counts() -> None:
    assert STRICT.score(answer("OPEN(fridge.10)", "OPEN(fridge.10)")).counted is None


def test_a_verdict_names_the_repairs_of_its_answer() -> None:
    assert STRICT.score(answer("SLEEP")).repairs == ("brackets",)


def test_errors_and_goals_are_those_of_the_reported_branch() -> None:
    verdict = STRICT.score(answer("OPEN(fridge.10)", "OPEN(fridge.10)", "HOLDS_RH(character.65, table.12)"))
    assert verdict.errors == (FaultKind.ADDITIONAL_STEP, FaultKind.AFFORDANCE)
    assert verdict.additional_steps == 1
    assert verdict.goals is not None
    assert verdict.goals == (Share(1, 1), Share(0, 1), Share(0, 1))
    assert (verdict.executable, verdict.success) == (False, False)


THREE_ACTIONS = replace(
    make_task(goals=("action TOUCH", "action TYPE", "action PUSH")), temporal_goal="exists x. (PUSH(x))"
)
POURED = replace(TASK, temporal_goal="exists x. (exists y. (POUR(x, y)))")
WITHOUT_GOALS = replace(make_task(goals=()), temporal_goal=None)


def test_action_goals_count_up_to_the_first_that_is_missing() -> None:
    goals = virtualhome_subgoals()(THREE_ACTIONS).score(answer("PUSH(table.12)", "TOUCH(table.12)")).goals
    assert goals is not None
    assert goals.action == Share(1, 3)


def test_a_goal_with_two_variables_is_read() -> None:
    assert describe_verdict(virtualhome_subgoals()(POURED).score(answer(*REACHED))) == "goal_unreachable"


@pytest.mark.parametrize(
    ("subgoal", "excluded"),
    [
        ("OPEN(fridge.10) and CLOSED(fridge.10)", True),
        ("OPEN(fridge.10) and not OPEN(fridge.10)", True),
        ("HOLDS_RH(character.65, cup.13) and HOLDS_LH(character.65, cup.13)", True),
        ("CLOSED(fridge.10) and (OPEN(fridge.10) or not CLOSED(fridge.10))", True),
        ("OPEN(fridge.10) and INSIDE(table.12, bed.20)", False),
        ("ONTOP(cup.13, bed.20) and ONTOP(cup.13, table.12)", True),
        ("HOLDS_RH(character.65, cup.13) and HOLDS_LH(character.65, table.12)", False),
        ("ONTOP(cup.13, bed.20) and ONTOP(cup.13, table.12) and HOLDS_RH(character.65, cup.13)", True),
        ("(OPEN(fridge.10) and CLOSED(fridge.10)) or HOLDS_LH(character.65, table.12)", False),
    ],
)
def test_a_subgoal_with_contradictory_parts_has_its_own_error(subgoal: str, excluded: bool) -> None:
    error = STRICT.score(answer(subgoal)).error
    assert error is not None
    is_contradiction = error.detail.endswith(" does not hold, and its parts exclude each other")
    assert (is_contradiction, error.check == "parts_exclude_each_other") == (excluded, excluded)


def test_states_that_hold_together_initially_do_not_contradict() -> None:
    task = make_task("OPEN fridge.10", goals=GOALS)
    scorer = virtualhome_subgoals()(task)
    assert scorer.score(answer("OPEN(fridge.10) and CLOSED(fridge.10)")).executable


def test_a_task_without_goals_is_excluded() -> None:
    assert virtualhome_subgoals()(WITHOUT_GOALS).score(answer(*REACHED)).excluded is not None


def test_a_verdict_says_why_the_search_ended() -> None:
    scorer = virtualhome_subgoals(ExplorationLimits(attempts=3))(TASK)
    verdict = scorer.score(answer(*REACHED))
    assert (verdict.search, verdict.tried_actions) == ("attempts", 4)
    assert any("the search was ended" in note for note in scorer.explain(answer(*REACHED)).notes)
    assert STRICT.score(answer(*REACHED)).search == "complete"


def test_a_subgoal_with_too_many_alternatives_is_an_error() -> None:
    four = " and ".join(f"exists {v}. (TOUCH({v}))" for v in "abcd")
    nested = "exists a. (exists b. (exists c. (exists d. (TOUCH(a) and TOUCH(b) and TOUCH(c) and TOUCH(d)))))"
    assert STRICT.score(answer(four, *REACHED[1:])).category is SubgoalAnswerCategory.RUNTIME
    verdict = STRICT.score(answer(nested))
    assert verdict.error is not None
    assert "20,000 instructions" in verdict.error.detail


def test_nested_quantifiers_over_pairs_are_counted_before_they_are_unfolded() -> None:
    more = [f"cup.{number}" for number in range(100, 120)]
    scorer = virtualhome_subgoals()(make_task(goals=GOALS, more_objects=more))
    pairs = "forpairs x, y. (forpairs z, w. (ONTOP(x, y) or ONTOP(z, w) or not ONTOP(x, w)))"
    verdict = scorer.score(answer(pairs))
    assert describe_verdict(verdict) == "not_parseable parsing"
    assert verdict.error is not None
    assert verdict.error.detail == "the answer expands to more than 100,000 literals"


def test_an_explanation_shows_the_subgoals_the_steps_and_the_goals() -> None:
    explanation = STRICT.explain(answer("OPEN(fridge.10)", "HOLDS_RH(character.65, table.12)"))
    assert explanation.notes == (
        "runtime",
        "subgoal 1: OPEN(fridge.10)",
        "subgoal 2: HOLDS_RH(character.65, table.12)",
        "subgoal 2 fails: affordance, table.12 cannot be grabbed",
    )
    assert [step.outcome for step in explanation.steps] == ["executed", "executed", "executed", "affordance"]
    assert [goal.satisfied for goal in explanation.goals] == [True, False, False]
    assert STRICT.explain(answer("FLY(table.12)")).notes[0] == "hallucination"
    assert STRICT.explain("nothing").notes[0] == "not_parseable"


PIECES = st.sampled_from(
    [
        *("OPEN(fridge.10)", "ONTOP(cup.13, bed.20)", "TOUCH(table)", "CLEAN(table.12)", "SLEEP()", "SLEEP"),
        *("INSIDE(milk.11, cup.13)", "ONTOP(character.65, bed.20)", "NEXT_TO(cup, bed)", "x = y", "ON(x)"),
        *(
            " and ",
            " or ",
            " then ",
            "not ",
            "(",
            ")",
            "exists x. (",
            "forall y. (",
            "forn 2. x. (",
            " implies ",
        ),
        *("next ", "until", "true", "é", "\0", ".", "FLY(\u00fc.1)"),
    ]
)
ANY_TEXT = st.text() | st.lists(st.lists(PIECES, max_size=6).map("".join), max_size=5).map(
    lambda subgoals: answer(*subgoals)
)


def assert_has_a_verdict(scorer: SubgoalDecompositionScorer, text: str) -> None:
    """Fail unless a text has an explanation, and equal verdicts when scored twice."""
    verdict = scorer.score(text)
    assert verdict.category is not None
    assert json.dumps(verdict_to_record_fields(verdict)) == json.dumps(
        verdict_to_record_fields(scorer.score(text))
    )
    json.dumps(dataclass_to_json(scorer.explain(text)))


@settings(deadline=None)
@given(ANY_TEXT)
def test_any_text_has_a_verdict(text: str) -> None:
    assert_has_a_verdict(STRICT, text)


@pytest.mark.parametrize(
    "subgoal",
    [
        "(" * 1_000 + "OPEN(fridge.10)" + ")" * 1_000,
        "not " * 1_000 + "OPEN(fridge.10)",
        "exists x. (" * 1_000 + "OPEN(x)" + ")" * 1_000,
        "exists x. (exists x. (OPEN(x))) and OPEN(x)",
        " and ".join(["OPEN(fridge.10)"] * 6_000),
        " or ".join(["OPEN(table.12)"] * 6_000),
        " then ".join(["CLEAN(table.12)"] * 6_000),
        " then ".join(["(SITTING(character.65) or ONTOP(character.65, bed.20))"] * 2_000),
        "OPEN(\u51b0\u7bb1.10)",
        "OPEN(" + "x" * 100_000 + ")",
        "forall x. (OPEN(x))",
        "forn 3. x. (OPEN(x))",
        "exists x:unicorn. (TOUCH(x))",
        "OPEN(fridge." + "9" * 10_000 + ")",
    ],
    ids=lambda text: text[:24].strip(),
)
def test_extreme_subgoals_have_a_verdict(scorer: SubgoalDecompositionScorer, subgoal: str) -> None:
    assert scorer.score(answer(subgoal)).category is not None


def test_forty_choices_do_not_cost_two_to_the_forty_executions() -> None:
    verdict = STRICT.score(answer(*["ONTOP(character.65, bed.20)"] * 40))
    assert verdict.search == "complete"
    assert verdict.tried_actions is not None
    assert verdict.tried_actions < 2_000


def test_many_threads_may_use_one_scorer(scorer: SubgoalDecompositionScorer) -> None:
    answers = [
        answer(*subgoals)
        for subgoals in (
            REACHED,
            (*REACHED, "forall x. (not HOLDS_RH(character.65, x))"),
            ("exists x. (TOUCH(x))", *REACHED[1:]),
            (*REACHED, "exists y. (HOLDS_RH(character.65, y))"),
            ("OPEN(fridge.10)", "ONTOP(cup.13, bed.20)", "TOUCH(table.12)"),
        )
    ]
    expected = [scorer.score(text) for text in answers]
    assert asked_by_threads(lambda i: scorer.score(answers[i % 5]) == expected[i % 5], 1_500)
