"""Verdicts on plans in VirtualHome: equal verdicts, and each difference from `strict`."""

from __future__ import annotations

from collections.abc import Sequence

import pytest
from hypothesis import given

from benchmarks.virtualhome.household import make_task
from benchmarks.virtualhome.test_plan_notation import PLANS, assert_reads_written_plan
from benchmarks.virtualhome.test_plans import (
    CUPS,
    CUPS_IN_KITCHEN,
    FRIDGE_OPEN,
    OUTCOMES,
    Score,
    describe_outcome,
    score_strictly,
    test_additional_steps_are_counted_and_skipped,
    test_an_answer_that_never_runs_counts_with_all_goals_unmet,
    test_goals_are_counted_in_the_state_in_which_a_plan_stops,
    test_steps_that_were_not_executed_reach_no_action_goal,
    write_answer,
)
from eai.abilities.verdict import PlanVerdict, SummaryCounts, Verdict
from eai.extensions.reference.virtualhome_plans import (
    GOLD_TEST,
    NOT_ACCEPTED,
    VirtualHomeActionSequencingScorer,
    _VirtualHomePlanNotation,
    do_most_answers_use_object_ids,
)
from eai.tasks.task import NO_GOALS, Task
from eai.world.action import Action
from eai.world.fault import FaultKind

SHARED = (
    test_an_answer_that_never_runs_counts_with_all_goals_unmet,
    test_goals_are_counted_in_the_state_in_which_a_plan_stops,
    test_additional_steps_are_counted_and_skipped,
    test_steps_that_were_not_executed_reach_no_action_goal,
)
"""Tests of `strict` that are run again with the fixture `score` below."""

OTHERWISE = {
    '{"WALK": ["fridge.10"]}': "hallucination 0",
    '{"WALK": [{"name": "fridge"}]}': "hallucination 0",
    '{"WALK": ["fridge", "10", "milk"]}': "parsing 0",
    '{"WALK": ["fridge", "10"], "OPEN": ["fridge"]}': "parsing 1",
    '{"FLY": ["moon", "10"], "WALK": ["fridge"]}': "parsing 1",
    '{"WALK": ["\0"]}': "parsing",
}
"""Outcomes that are not those of `strict`."""


def score_as_reference(text: str, task: Task) -> Verdict:
    return VirtualHomeActionSequencingScorer(task).score(text)


@pytest.fixture
def score() -> Score:
    return score_as_reference


def counted(text: str, task: Task | None = None) -> SummaryCounts | None:
    """Return the counts of an answer in a summary, if they are not those of its verdict."""
    verdict = score_as_reference(text, task or make_task())
    assert isinstance(verdict, PlanVerdict)
    return verdict.counted


@pytest.mark.parametrize(("text", "strict"), OUTCOMES, ids=str)
def test_an_answer_has_its_outcome(text: str, strict: str) -> None:
    assert describe_outcome(score_as_reference(text, make_task())) == OTHERWISE.get(text, strict)


def test_a_name_alone_means_the_last_object_of_its_class_in_a_hash_table() -> None:
    """A Python set of 90, 13 and 80 is iterated as 80, 90, 13."""
    task = make_task(*CUPS_IN_KITCHEN, "NEXT_TO character.65 cup.13", **CUPS)
    (step,) = VirtualHomeActionSequencingScorer(task).explain('{"TOUCH": ["cup"]}').steps
    assert (step.action, step.outcome) == ("TOUCH(cup.13)", "executed")


@pytest.mark.parametrize(
    ("answers", "with_ids"),
    [
        ([write_answer("WALK fridge.10")], True),
        ([FRIDGE_OPEN], False),
        ([FRIDGE_OPEN, write_answer("WALK fridge.10"), write_answer("WALK cup.13")], True),
        ([FRIDGE_OPEN, write_answer("WALK fridge.10")], False),
        (["", "no plan", '{"STANDUP": [ ]}', write_answer("WALK fridge.10")], True),
        ([], False),
    ],
)
def test_most_answers_of_a_file_decide_how_all_are_read(answers: Sequence[str], *, with_ids: bool) -> None:
    assert do_most_answers_use_object_ids(answers) is with_ids


@pytest.mark.parametrize(
    ("with_ids", "text", "outcome"),
    [
        (True, FRIDGE_OPEN, "parsing 0"),
        (False, write_answer("WALK fridge.10", "OPEN fridge.10"), "hallucination 0"),
        (None, FRIDGE_OPEN, "success"),
        (None, write_answer("WALK fridge.10", "OPEN fridge.10"), "success"),
    ],
)
def test_the_form_of_the_file_binds_each_answer(with_ids: bool | None, text: str, outcome: str) -> None:
    assert (
        describe_outcome(VirtualHomeActionSequencingScorer(make_task(), with_ids=with_ids).score(text))
        == outcome
    )


# The differences between the protocols, one by one (docs/extensions/reference).


def both(task: Task, text: str) -> tuple[str, str]:
    return describe_outcome(score_strictly(text, task)), describe_outcome(score_as_reference(text, task))


def test_a_task_with_several_relation_goals_counts_under_strict_only() -> None:
    task = make_task(
        goals=("relation ONTOP cup.13 table.12", "relation ONTOP bread.14 table.12"),
        script=["WALK fridge.10"],
    )
    assert describe_outcome(score_strictly(write_answer("WALK table.12"), task)) == "success"
    assert score_as_reference(write_answer("WALK table.12"), task) == PlanVerdict(excluded=GOLD_TEST)


def test_a_task_without_goals_is_excluded_under_strict() -> None:
    task = make_task(goals=())
    assert score_strictly(FRIDGE_OPEN, task) == PlanVerdict(excluded=NO_GOALS)
    assert score_as_reference(FRIDGE_OPEN, task).excluded is None


def test_a_task_whose_annotation_misses_its_goal_counts_under_strict_only() -> None:
    task = make_task(goals=("state ON television.22",), final=())
    assert score_strictly(FRIDGE_OPEN, task).excluded is None
    assert score_as_reference(FRIDGE_OPEN, task).excluded == GOLD_TEST


def test_a_plan_equal_to_the_script_succeeds_under_strict() -> None:
    task = make_task(script=["WALK fridge.10", "OPEN fridge.10"])
    text = write_answer("WALK fridge.10", "OPEN fridge.10")
    strict, reference = score_strictly(text, task), score_as_reference(text, task)
    assert (strict.executable, strict.success) == (True, True)
    assert (reference.executable, reference.success, reference.error) == (True, False, None)
    assert reference.goals is not None
    assert reference.goals.state == (0, 1)
    assert both(task, write_answer("WALK table.12", "WALK fridge.10", "OPEN fridge.10")) == (
        "success",
        "success",
    )


def test_an_empty_list_is_a_step_under_strict() -> None:
    task = make_task("SITTING character.65", goals=("action WALK",))
    text = '{"STANDUP": [], "WALK": ["fridge"]}'
    assert both(task, text) == ("success", "missing_step 0")
    assert both(task, text.replace("[]", "[ ]")) == ("success", "success")


def test_an_unreadable_list_counts_once_under_strict() -> None:
    twice = counted('{"WALK": [fridge]}')
    assert twice is not None
    assert (twice.success, twice.errors) == (False, {FaultKind.PARSING: 2})
    assert counted("I cannot.") is None
    strict = score_strictly('{"WALK": [fridge]}', make_task())
    assert isinstance(strict, PlanVerdict)
    assert strict.counted is None


def test_every_additional_step_counts_in_the_reference() -> None:
    once = counted(write_answer("STANDUP", "WALK fridge.10", "OPEN fridge.10"))
    thrice = counted(write_answer("STANDUP", "STANDUP", "STANDUP", "OPEN fridge.10"))
    assert once is None
    assert thrice is not None
    assert thrice.errors == {FaultKind.MISSING_STEP: 1, FaultKind.ADDITIONAL_STEP: 3}
    assert thrice.goals == score_as_reference("", make_task()).goals


@pytest.mark.parametrize("action", NOT_ACCEPTED)
def test_actions_that_the_prompt_offers_are_accepted_under_strict(action: str) -> None:
    device = {"PLUGIN": "television.22", "PLUGOUT": "fridge.10", "RELEASE": "cup.13"}[action]
    task = make_task(
        f"NEXT_TO character.65 {device}", "HOLDS_RH character.65 cup.13", goals=(f"action {action}",)
    )
    assert both(task, write_answer(f"{action} {device}")) == ("success", "hallucination 0")


def test_any_object_may_be_named_with_its_id_under_strict() -> None:
    task = make_task(relevant=["fridge.10"], goals=("action WALK",))
    assert both(task, write_answer("WALK table.12")) == ("success", "hallucination 0")
    assert both(task, '{"WALK": ["table"]}') == ("hallucination 0", "hallucination 0")


def test_success_needs_an_executable_plan_under_strict() -> None:
    task = make_task(goals=("state OPEN fridge.10",))
    text = write_answer("WALK fridge.10", "OPEN fridge.10", "READ book.16")
    strict, reference = score_strictly(text, task), score_as_reference(text, task)
    assert (strict.executable, strict.success) == (False, False)
    assert (reference.executable, reference.success) == (False, True)


def test_checks_are_made_in_the_order_of_the_paper_under_strict() -> None:
    task = make_task(goals=("action SIT",))
    assert both(task, write_answer("SIT table.12")) == ("affordance 0", "missing_step 0")


def test_an_unplugged_device_is_a_missing_step_under_strict() -> None:
    task = make_task("NEXT_TO character.65 television.22", goals=("state ON television.22",))
    assert both(task, write_answer("SWITCHON television.22")) == ("missing_step 0", "failure")
    assert score_as_reference(write_answer("SWITCHON television.22"), task).additional_steps == 1
    assert (
        describe_outcome(score_strictly(write_answer("PLUGIN television.22", "SWITCHON television.22"), task))
        == "success"
    )


def test_a_closed_container_is_a_missing_step_under_strict() -> None:
    task = make_task("NEXT_TO character.65 fridge.10", "HOLDS_RH character.65 cup.13")
    assert both(task, write_answer("PUTIN cup.13 fridge.10")) == ("missing_step 0", "affordance 0")


def test_an_object_in_a_container_that_was_open_once_is_a_wrong_order_under_strict() -> None:
    text = write_answer("WALK fridge.10", "OPEN fridge.10", "CLOSE fridge.10", "GRAB milk.11")
    assert both(make_task(), text) == ("wrong_order 3", "missing_step 3")


def test_held_objects_come_along_under_strict() -> None:
    task = make_task("NEXT_TO character.65 book.16", goals=("relation INSIDE book.16 kitchen.1",))
    assert both(task, write_answer("GRAB book.16", "WALK kitchen.1")) == ("success", "failure")


def test_putting_back_can_fail_under_strict() -> None:
    task = make_task("NEXT_TO character.65 cup.13", goals=("relation ONTOP cup.13 table.12",))
    grab = "GRAB cup.13"
    assert both(task, write_answer(grab, "WALK bed.20", "PUTOBJBACK cup.13")) == ("wrong_order 2", "failure")
    assert both(task, write_answer(grab, "WALK table.12", "PUTOBJBACK cup.13")) == ("success", "success")


@pytest.mark.parametrize(
    ("step", "strict"),
    [
        ("PUTOBJBACK cup.13", "missing_step 0"),
        ("LOOKAT_LONG television.22", "missing_step 0"),
        ("LOOKAT_SHORT television.22", "missing_step 0"),
        ("WALK cloud.30", "affordance 0"),
    ],
)
def test_what_aborts_the_reference_is_an_error_of_the_row(step: str, strict: str) -> None:
    assert both(make_task(), write_answer(step)) == (strict, "uncategorised 0")


def test_two_action_goals_count_in_their_order_under_strict() -> None:
    task = make_task(
        "NEXT_TO character.65 fridge.10",
        "-OFF fridge.10",
        "ON fridge.10",
        "NEXT_TO character.65 keyboard.23",
        goals=("action TYPE", "action SWITCHOFF"),
    )
    in_order = write_answer("TYPE keyboard.23", "SWITCHOFF fridge.10")
    reversed_order = write_answer("SWITCHOFF fridge.10", "TYPE keyboard.23")
    assert both(task, in_order) == ("success", "failure")
    assert both(task, reversed_order) == ("failure", "success")
    told_besides = counted(in_order, task)
    assert told_besides is not None
    assert (told_besides.success, told_besides.goals.action) == (True, (2, 2))
    assert told_besides.errors == {}


@given(PLANS)
def test_plans_that_are_written_under_strict_are_read(plan: list[Action]) -> None:
    for notation in (_VirtualHomePlanNotation(), _VirtualHomePlanNotation(with_ids=True)):
        assert_reads_written_plan(notation, plan)
