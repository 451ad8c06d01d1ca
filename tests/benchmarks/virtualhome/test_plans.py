from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import pytest

from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.abilities.verdict import PlanVerdict, Verdict
from eai.tasks.task import NO_GOALS, Task

Score: TypeAlias = Callable[[str, Task], Verdict]
CUPS_IN_KITCHEN = ("INSIDE cup.80 kitchen.1", "INSIDE cup.90 kitchen.1")
CUPS: Mapping[str, Any] = {
    "relevant": ("cup.90", "cup.13", "cup.80"),
    "more_objects": ("cup.80", "cup.90"),
    "goals": ("action TOUCH",),
}
"""A task to touch one of three cups."""

FRIDGE_OPEN = '{"WALK": ["fridge"], "OPEN": ["fridge"]}'


def score_strictly(text: str, task: Task) -> Verdict:
    return virtualhome_scorer(task).score(text)


@pytest.fixture
def score() -> Score:
    """Return the scoring function under `strict`. Tests of other protocols override this fixture."""
    return score_strictly


def describe_outcome(verdict: Verdict) -> str:
    """Return the kind and step of the error, or whether the goals were reached."""
    if verdict.excluded is not None:
        return "excluded"
    if verdict.error is None:
        return "success" if verdict.success else "failure"
    step = "" if verdict.error.step is None else f" {verdict.error.step}"
    return verdict.error.kind.value + step


def write_answer(*steps: str) -> str:
    """Return an answer with names and ids, from steps such as ``GRAB cup.13``."""
    pairs = []
    for step in steps:
        action, *names = step.split()
        arguments = [part for name in names for part in name.rsplit(".", 1)]
        pairs.append(f'"{action}": {json.dumps(arguments) if arguments else "[ ]"}')
    return "{" + ", ".join(pairs) + "}"


OUTCOMES = [
    # Names alone, names with ids, ids as numbers, actions in lower case.
    (FRIDGE_OPEN, "success"),
    ('{"WALK": ["fridge", "10"], "OPEN": ["fridge", "10"]}', "success"),
    ('{"WALK": ["fridge", 10], "OPEN": ["fridge", 10]}', "success"),
    ('{"walk": ["fridge"], "Open": ["fridge"]}', "success"),
    # Unknown words.
    ('{"FLY": ["fridge"]}', "hallucination 0"),
    ('{"WALK": ["fridge"], "OPEN": ["moon"]}', "hallucination 1"),
    ('{"WALK": ["Fridge"]}', "hallucination 0"),
    ('{"WALK": ["fridge", "11"]}', "hallucination 0"),
    ('{"WALK": ["fridge", "010"]}', "hallucination 0"),
    ('{"WALK": ["fridge.10"]}', "failure"),
    ('{"WALK": [""]}', "hallucination 0"),
    ('{"WALK": ["10"]}', "hallucination 0"),
    ('{"WALK": [null]}', "hallucination 0"),
    ('{"WALK": [true, 1.5]}', "hallucination 0"),
    ('{"WALK": [{"name": "fridge"}]}', "parsing"),
    ('{"WALK": ["\ud800"]}', "hallucination 0"),
    # A name without an id next to names with ids.
    ('{"WALK": ["fridge", "10", "milk"]}', "hallucination 0"),
    ('{"WALK": ["fridge", "10"], "OPEN": ["fridge"]}', "hallucination 1"),
    # Too many or too few objects.
    ('{"WALK": ["fridge", "milk"]}', "argument_number 0"),
    ('{"WALK": ["fridge"], "PUTIN": ["milk"]}', "argument_number 1"),
    ('{"STANDUP": ["fridge", "10"]}', "argument_number 0"),
    # Whole plans are tested: parsing before hallucination before argument number.
    ('{"WALK": [ ], "FLY": ["moon"]}', "hallucination 1"),
    ('{"FLY": ["moon", "10"], "WALK": ["fridge"]}', "hallucination 0"),
    ('{"OPEN": ["fridge"], "WALK": [ ]}', "argument_number 1"),
    # Unreadable answers.
    ("I cannot.", "parsing"),
    ("", "parsing"),
    ('{"WALK": [fridge]}', "parsing"),
    ('{"WALK": ["\0"]}', "hallucination 0"),
    # Outcomes of plans that run.
    ('{"OPEN": ["fridge"]}', "missing_step 0"),
    ('{"WALK": ["table"], "GRAB": ["table"]}', "affordance 1"),
    ('{"WALK": ["fridge"]}', "failure"),
]


@pytest.mark.parametrize(("text", "outcome"), OUTCOMES, ids=str)
def test_an_answer_has_its_expected_outcome(text: str, outcome: str) -> None:
    assert describe_outcome(score_strictly(text, make_task())) == outcome


@pytest.mark.parametrize("text", ["", '{"FLY": ["moon"]}', '{"WALK": [ ]}'])
def test_an_answer_that_never_runs_counts_with_all_goals_unmet(score: Score, text: str) -> None:
    verdict = score(text, make_task())
    assert (verdict.executable, verdict.success, verdict.additional_steps) == (False, False, 0)
    assert verdict.goals is not None
    assert verdict.goals.state == (0, 1)


def test_goals_are_counted_in_the_state_in_which_a_plan_stops(score: Score) -> None:
    verdict = score('{"WALK": ["fridge"], "OPEN": ["fridge"], "READ": ["book"]}', make_task())
    assert describe_outcome(verdict) == "missing_step 2"
    assert verdict.executable is False
    assert verdict.goals is not None
    assert verdict.goals.state == (1, 1)


def test_additional_steps_are_counted_and_skipped(score: Score) -> None:
    text = '{"STANDUP": [ ], "WALK": ["fridge"], "OPEN": ["fridge"], "OPEN": ["fridge"]}'
    verdict = score(text, make_task())
    assert (describe_outcome(verdict), verdict.executable, verdict.additional_steps) == ("success", True, 2)


@pytest.mark.parametrize("steps", [("STANDUP",), ("READ book.16",)])
def test_steps_that_were_not_executed_reach_no_action_goal(score: Score, steps: Sequence[str]) -> None:
    task = make_task(goals=("action STANDUP|READ",))
    assert describe_outcome(score(write_answer(*steps), task)) in {"failure", "missing_step 0"}
    assert score(write_answer(*steps), task).success is False


def test_a_name_alone_means_the_last_relevant_object_of_its_class() -> None:
    task = make_task(*CUPS_IN_KITCHEN, "NEXT_TO character.65 cup.80", **CUPS)
    (step,) = virtualhome_scorer(task).explain('{"TOUCH": ["cup"]}').steps
    assert (step.action, step.outcome) == ("TOUCH(cup.80)", "executed")


def test_a_task_with_several_relation_goals_is_scored() -> None:
    task = make_task(
        goals=("relation ONTOP cup.13 table.12", "relation ONTOP bread.14 table.12"),
        script=["WALK fridge.10"],
    )
    assert describe_outcome(score_strictly(write_answer("WALK table.12"), task)) == "success"


def test_a_task_without_goals_is_excluded() -> None:
    task = make_task(goals=())
    assert score_strictly(FRIDGE_OPEN, task) == PlanVerdict(excluded=NO_GOALS)


def test_a_task_whose_annotated_state_misses_its_goal_is_scored() -> None:
    task = make_task(goals=("state ON television.22",), final=())
    assert score_strictly(FRIDGE_OPEN, task).excluded is None


def test_a_plan_equal_to_the_script_succeeds() -> None:
    task = make_task(script=["WALK fridge.10", "OPEN fridge.10"])
    text = write_answer("WALK fridge.10", "OPEN fridge.10")
    verdict = score_strictly(text, task)
    assert (verdict.executable, verdict.success) == (True, True)
    assert (
        describe_outcome(
            score_strictly(write_answer("WALK table.12", "WALK fridge.10", "OPEN fridge.10"), task)
        )
        == "success"
    )


def test_an_empty_list_is_a_step() -> None:
    task = make_task("SITTING character.65", goals=("action WALK",))
    text = '{"STANDUP": [], "WALK": ["fridge"]}'
    assert describe_outcome(score_strictly(text, task)) == "success"
    assert describe_outcome(score_strictly(text.replace("[]", "[ ]"), task)) == "success"


@pytest.mark.parametrize(
    ("action", "device"), [("PLUGIN", "television.22"), ("PLUGOUT", "fridge.10"), ("RELEASE", "cup.13")]
)
def test_actions_that_the_prompt_offers_are_accepted(action: str, device: str) -> None:
    task = make_task(
        f"NEXT_TO character.65 {device}", "HOLDS_RH character.65 cup.13", goals=(f"action {action}",)
    )
    assert describe_outcome(score_strictly(write_answer(f"{action} {device}"), task)) == "success"


def test_any_object_may_be_named_with_its_id() -> None:
    task = make_task(relevant=["fridge.10"], goals=("action WALK",))
    assert describe_outcome(score_strictly(write_answer("WALK table.12"), task)) == "success"
    assert describe_outcome(score_strictly('{"WALK": ["table"]}', task)) == "hallucination 0"


def test_cached_steps_are_distinguished_from_steps_that_python_calls_equal() -> None:
    scorer = virtualhome_scorer(make_task())
    texts = [f'{{"WALK": ["fridge", {written}]}}' for written in ('"10"', "10", "10.0", '"10"')]
    outcomes = [describe_outcome(scorer.score(text)) for text in (*texts, *reversed(texts))]
    fresh = [describe_outcome(score_strictly(text, make_task())) for text in texts]
    assert outcomes == [*fresh, *reversed(fresh)]
    assert len({*fresh}) == 2, "one of them stands for no object"


def test_success_needs_an_executable_plan() -> None:
    task = make_task(goals=("state OPEN fridge.10",))
    text = write_answer("WALK fridge.10", "OPEN fridge.10", "READ book.16")
    verdict = score_strictly(text, task)
    assert (verdict.executable, verdict.success) == (False, False)


def test_checks_are_made_in_the_order_of_the_paper() -> None:
    task = make_task(goals=("action SIT",))
    assert describe_outcome(score_strictly(write_answer("SIT table.12"), task)) == "affordance 0"


def test_an_unplugged_device_is_a_missing_step() -> None:
    task = make_task("NEXT_TO character.65 television.22", goals=("state ON television.22",))
    assert describe_outcome(score_strictly(write_answer("SWITCHON television.22"), task)) == "missing_step 0"
    assert (
        describe_outcome(score_strictly(write_answer("PLUGIN television.22", "SWITCHON television.22"), task))
        == "success"
    )


def test_a_closed_container_is_a_missing_step() -> None:
    task = make_task("NEXT_TO character.65 fridge.10", "HOLDS_RH character.65 cup.13")
    assert describe_outcome(score_strictly(write_answer("PUTIN cup.13 fridge.10"), task)) == "missing_step 0"


def test_an_object_in_a_container_that_was_open_once_is_a_wrong_order() -> None:
    text = write_answer("WALK fridge.10", "OPEN fridge.10", "CLOSE fridge.10", "GRAB milk.11")
    assert describe_outcome(score_strictly(text, make_task())) == "wrong_order 3"


def test_held_objects_come_along() -> None:
    task = make_task("NEXT_TO character.65 book.16", goals=("relation INSIDE book.16 kitchen.1",))
    assert describe_outcome(score_strictly(write_answer("GRAB book.16", "WALK kitchen.1"), task)) == "success"


def test_putting_an_object_back_needs_its_former_place_nearby() -> None:
    task = make_task("NEXT_TO character.65 cup.13", goals=("relation ONTOP cup.13 table.12",))
    grab = "GRAB cup.13"
    assert (
        describe_outcome(score_strictly(write_answer(grab, "WALK bed.20", "PUTOBJBACK cup.13"), task))
        == "wrong_order 2"
    )
    assert (
        describe_outcome(score_strictly(write_answer(grab, "WALK table.12", "PUTOBJBACK cup.13"), task))
        == "success"
    )


@pytest.mark.parametrize(
    ("step", "outcome"),
    [
        ("PUTOBJBACK cup.13", "missing_step 0"),
        ("LOOKAT_LONG television.22", "missing_step 0"),
        ("LOOKAT_SHORT television.22", "missing_step 0"),
        ("WALK cloud.30", "affordance 0"),
    ],
)
def test_an_action_that_cannot_be_executed_is_an_error(step: str, outcome: str) -> None:
    assert describe_outcome(score_strictly(write_answer(step), make_task())) == outcome


def test_two_action_goals_count_in_their_order() -> None:
    task = make_task(
        "NEXT_TO character.65 fridge.10",
        "-OFF fridge.10",
        "ON fridge.10",
        "NEXT_TO character.65 keyboard.23",
        goals=("action TYPE", "action SWITCHOFF"),
    )
    in_order = write_answer("TYPE keyboard.23", "SWITCHOFF fridge.10")
    reversed_order = write_answer("SWITCHOFF fridge.10", "TYPE keyboard.23")
    assert describe_outcome(score_strictly(in_order, task)) == "success"
    assert describe_outcome(score_strictly(reversed_order, task)) == "failure"
