from __future__ import annotations

import json
from collections.abc import Sequence

import pytest

from benchmarks.plan_scorers import virtualhome_scorer
from benchmarks.virtualhome.household import make_task
from eai.abilities.protocol import Protocol
from eai.abilities.verdict import Counted, PlanVerdict, Verdict
from eai.tasks.task import NO_GOALS, Task
from eai.world.fault import FaultKind
from protocols import of_reference

virtualhome_plans = of_reference("virtualhome_plans")

STRICT, REFERENCE = Protocol.STRICT, Protocol("eai-1.0.5")
BOTH = pytest.mark.parametrize("protocol", list(Protocol.known()), ids=lambda protocol: protocol.value)
FRIDGE_OPEN = '{"WALK": ["fridge"], "OPEN": ["fridge"]}'


def score(
    protocol: Protocol, text: str, task: Task | None = None, *, with_ids: bool | None = None
) -> Verdict:
    return virtualhome_scorer(task or make_task(), protocol, with_ids=with_ids).score(text)


def counted(text: str, task: Task | None = None) -> Counted | None:
    """What an answer counts as in a summary of the reference, where that is not what its verdict says."""
    verdict = score(REFERENCE, text, task)
    assert isinstance(verdict, PlanVerdict)
    return verdict.counted


def told(verdict: Verdict) -> str:
    """The error with its step, else whether the goals were reached."""
    if verdict.excluded is not None:
        return "excluded"
    if verdict.error is None:
        return "success" if verdict.success else "failure"
    step = "" if verdict.error.step is None else f" {verdict.error.step}"
    return verdict.error.kind.value + step


def plan(*steps: str) -> str:
    """An answer with names and ids from steps like ``GRAB cup.13``."""
    pairs = []
    for step in steps:
        action, *names = step.split()
        arguments = [part for name in names for part in name.rsplit(".", 1)]
        pairs.append(f'"{action}": {json.dumps(arguments) if arguments else "[ ]"}')
    return "{" + ", ".join(pairs) + "}"


@pytest.mark.parametrize(
    ("text", "strict", "reference"),
    [
        # Names alone, names with ids, ids as numbers, actions in lower case.
        (FRIDGE_OPEN, "success", "success"),
        ('{"WALK": ["fridge", "10"], "OPEN": ["fridge", "10"]}', "success", "success"),
        ('{"WALK": ["fridge", 10], "OPEN": ["fridge", 10]}', "success", "success"),
        ('{"walk": ["fridge"], "Open": ["fridge"]}', "success", "success"),
        # Unknown words.
        ('{"FLY": ["fridge"]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": ["fridge"], "OPEN": ["moon"]}', "hallucination 1", "hallucination 1"),
        ('{"WALK": ["Fridge"]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": ["fridge", "11"]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": ["fridge", "010"]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": ["fridge.10"]}', "failure", "hallucination 0"),
        ('{"WALK": [""]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": ["10"]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": [null]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": [true, 1.5]}', "hallucination 0", "hallucination 0"),
        ('{"WALK": [{"name": "fridge"}]}', "parsing", "hallucination 0"),
        ('{"WALK": ["\ud800"]}', "hallucination 0", "hallucination 0"),
        # A name without an id where others have one.
        ('{"WALK": ["fridge", "10", "milk"]}', "hallucination 0", "parsing 0"),
        ('{"WALK": ["fridge", "10"], "OPEN": ["fridge"]}', "hallucination 1", "parsing 1"),
        # Too many or too few objects.
        ('{"WALK": ["fridge", "milk"]}', "argument_number 0", "argument_number 0"),
        ('{"WALK": ["fridge"], "PUTIN": ["milk"]}', "argument_number 1", "argument_number 1"),
        ('{"STANDUP": ["fridge", "10"]}', "argument_number 0", "argument_number 0"),
        # Whole plans are tested: parsing before hallucination before argument number.
        ('{"WALK": [ ], "FLY": ["moon"]}', "hallucination 1", "hallucination 1"),
        ('{"FLY": ["moon", "10"], "WALK": ["fridge"]}', "hallucination 0", "parsing 1"),
        ('{"OPEN": ["fridge"], "WALK": [ ]}', "argument_number 1", "argument_number 1"),
        # Nothing to read.
        ("I cannot.", "parsing", "parsing"),
        ("", "parsing", "parsing"),
        ('{"WALK": [fridge]}', "parsing", "parsing"),
        ('{"WALK": ["\0"]}', "hallucination 0", "parsing"),
        # What happens when the plan runs.
        ('{"OPEN": ["fridge"]}', "missing_step 0", "missing_step 0"),
        ('{"WALK": ["table"], "GRAB": ["table"]}', "affordance 1", "affordance 1"),
        ('{"WALK": ["fridge"]}', "failure", "failure"),
    ],
    ids=str,
)
def test_an_answer_under_both_protocols(text: str, strict: str, reference: str) -> None:
    assert (told(score(STRICT, text)), told(score(REFERENCE, text))) == (strict, reference)


@BOTH
@pytest.mark.parametrize("text", ["", '{"FLY": ["moon"]}', '{"WALK": [ ]}'])
def test_an_answer_that_never_runs_is_counted_with_all_goals_unmet(protocol: Protocol, text: str) -> None:
    verdict = score(protocol, text)
    assert (verdict.executable, verdict.success, verdict.additional_steps) == (False, False, 0)
    assert verdict.goals is not None
    assert verdict.goals.state == (0, 1)


@BOTH
def test_goals_count_in_the_state_in_which_a_plan_stopped(protocol: Protocol) -> None:
    verdict = score(protocol, '{"WALK": ["fridge"], "OPEN": ["fridge"], "READ": ["book"]}')
    assert told(verdict) == "missing_step 2"
    assert verdict.executable is False
    assert verdict.goals is not None
    assert verdict.goals.state == (1, 1)


@BOTH
def test_additional_steps_are_counted_and_skipped(protocol: Protocol) -> None:
    verdict = score(protocol, '{"STANDUP": [ ], "WALK": ["fridge"], "OPEN": ["fridge"], "OPEN": ["fridge"]}')
    assert (told(verdict), verdict.executable, verdict.additional_steps) == ("success", True, 2)


@BOTH
@pytest.mark.parametrize("steps", [("STANDUP",), ("READ book.16",)])
def test_steps_that_were_not_executed_reach_no_action_goal(protocol: Protocol, steps: Sequence[str]) -> None:
    task = make_task(goals=("action STANDUP|READ",))
    assert told(score(protocol, plan(*steps), task)) in {"failure", "missing_step 0"}
    assert score(protocol, plan(*steps), task).success is False


@pytest.mark.parametrize(
    ("protocol", "cup"),
    [
        (STRICT, "cup.80"),
        # A Python set of 90, 13 and 80 is iterated as 80, 90, 13.
        (REFERENCE, "cup.13"),
    ],
)
def test_a_name_alone_means_the_last_relevant_object_of_its_class(protocol: Protocol, cup: str) -> None:
    cups = ("cup.90", "cup.13", "cup.80")
    facts = ("INSIDE cup.80 kitchen.1", "INSIDE cup.90 kitchen.1", f"NEXT_TO character.65 {cup}")
    task = make_task(*facts, relevant=cups, more_objects=("cup.80", "cup.90"), goals=("action TOUCH",))
    explanation = virtualhome_scorer(task, protocol).explain('{"TOUCH": ["cup"]}')
    assert explanation.steps[0].action == f"TOUCH({cup})"
    assert explanation.steps[0].outcome == "executed"


@pytest.mark.parametrize(
    ("answers", "with_ids"),
    [
        ([plan("WALK fridge.10")], True),
        ([FRIDGE_OPEN], False),
        ([FRIDGE_OPEN, plan("WALK fridge.10"), plan("WALK cup.13")], True),
        ([FRIDGE_OPEN, plan("WALK fridge.10")], False),
        (["", "no plan", '{"STANDUP": [ ]}', plan("WALK fridge.10")], True),
        ([], False),
    ],
)
def test_most_answers_of_a_file_decide_how_all_are_read(answers: Sequence[str], *, with_ids: bool) -> None:
    assert virtualhome_plans.written_with_ids(answers) is with_ids


@pytest.mark.parametrize(
    ("with_ids", "text", "outcome"),
    [
        (True, FRIDGE_OPEN, "parsing 0"),
        (False, plan("WALK fridge.10", "OPEN fridge.10"), "hallucination 0"),
        (None, FRIDGE_OPEN, "success"),
        (None, plan("WALK fridge.10", "OPEN fridge.10"), "success"),
    ],
)
def test_the_form_of_the_file_binds_each_answer(with_ids: bool | None, text: str, outcome: str) -> None:
    assert told(score(REFERENCE, text, with_ids=with_ids)) == outcome


# The differences between the protocols, one by one (docs/extensions/reference).


def both(task: Task, text: str) -> tuple[str, str]:
    return told(score(STRICT, text, task)), told(score(REFERENCE, text, task))


def test_a_task_with_several_relation_goals_counts_under_strict_only() -> None:
    task = make_task(
        goals=("relation ONTOP cup.13 table.12", "relation ONTOP bread.14 table.12"),
        script=["WALK fridge.10"],
    )
    assert told(score(STRICT, plan("WALK table.12"), task)) == "success"
    assert score(REFERENCE, plan("WALK table.12"), task) == PlanVerdict(excluded=virtualhome_plans.GOLD_TEST)


def test_a_task_without_goals_is_excluded_under_strict() -> None:
    task = make_task(goals=())
    assert score(STRICT, FRIDGE_OPEN, task) == PlanVerdict(excluded=NO_GOALS)
    assert score(REFERENCE, FRIDGE_OPEN, task).excluded is None


def test_a_task_whose_annotation_misses_its_goal_counts_under_strict_only() -> None:
    task = make_task(goals=("state ON television.22",), final=())
    assert score(STRICT, FRIDGE_OPEN, task).excluded is None
    assert score(REFERENCE, FRIDGE_OPEN, task).excluded == virtualhome_plans.GOLD_TEST


def test_a_plan_equal_to_the_script_succeeds_under_strict() -> None:
    task = make_task(script=["WALK fridge.10", "OPEN fridge.10"])
    text = plan("WALK fridge.10", "OPEN fridge.10")
    strict, reference = score(STRICT, text, task), score(REFERENCE, text, task)
    assert (strict.executable, strict.success) == (True, True)
    assert (reference.executable, reference.success, reference.error) == (True, False, None)
    assert reference.goals is not None
    assert reference.goals.state == (0, 1)
    assert both(task, plan("WALK table.12", "WALK fridge.10", "OPEN fridge.10")) == ("success", "success")


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
    strict = score(STRICT, '{"WALK": [fridge]}')
    assert isinstance(strict, PlanVerdict)
    assert strict.counted is None


def test_every_additional_step_counts_in_the_reference() -> None:
    once = counted(plan("STANDUP", "WALK fridge.10", "OPEN fridge.10"))
    thrice = counted(plan("STANDUP", "STANDUP", "STANDUP", "OPEN fridge.10"))
    assert once is None
    assert thrice is not None
    assert thrice.errors == {FaultKind.MISSING_STEP: 1, FaultKind.ADDITIONAL_STEP: 3}
    assert thrice.goals == score(REFERENCE, "").goals


@pytest.mark.parametrize("action", virtualhome_plans.NOT_ACCEPTED)
def test_actions_that_the_prompt_offers_are_accepted_under_strict(action: str) -> None:
    device = {"PLUGIN": "television.22", "PLUGOUT": "fridge.10", "RELEASE": "cup.13"}[action]
    task = make_task(
        f"NEXT_TO character.65 {device}", "HOLDS_RH character.65 cup.13", goals=(f"action {action}",)
    )
    assert both(task, plan(f"{action} {device}")) == ("success", "hallucination 0")


def test_any_object_may_be_named_with_its_id_under_strict() -> None:
    task = make_task(relevant=["fridge.10"], goals=("action WALK",))
    assert both(task, plan("WALK table.12")) == ("success", "hallucination 0")
    assert both(task, '{"WALK": ["table"]}') == ("hallucination 0", "hallucination 0")


def test_steps_that_are_remembered_are_told_from_others_that_are_equal_in_python() -> None:
    scorer = virtualhome_scorer(make_task(), STRICT)
    texts = [f'{{"WALK": ["fridge", {written}]}}' for written in ('"10"', "10", "10.0", '"10"')]
    outcomes = [told(scorer.score(text)) for text in (*texts, *reversed(texts))]
    fresh = [told(score(STRICT, text)) for text in texts]
    assert outcomes == [*fresh, *reversed(fresh)]
    assert len({*fresh}) == 2, "one of them stands for no object"


def test_success_needs_an_executable_plan_under_strict() -> None:
    task = make_task(goals=("state OPEN fridge.10",))
    text = plan("WALK fridge.10", "OPEN fridge.10", "READ book.16")
    strict, reference = score(STRICT, text, task), score(REFERENCE, text, task)
    assert (strict.executable, strict.success) == (False, False)
    assert (reference.executable, reference.success) == (False, True)


def test_checks_are_made_in_the_order_of_the_paper_under_strict() -> None:
    task = make_task(goals=("action SIT",))
    assert both(task, plan("SIT table.12")) == ("affordance 0", "missing_step 0")


def test_an_unplugged_device_is_a_missing_step_under_strict() -> None:
    task = make_task("NEXT_TO character.65 television.22", goals=("state ON television.22",))
    assert both(task, plan("SWITCHON television.22")) == ("missing_step 0", "failure")
    assert score(REFERENCE, plan("SWITCHON television.22"), task).additional_steps == 1
    assert told(score(STRICT, plan("PLUGIN television.22", "SWITCHON television.22"), task)) == "success"


def test_a_closed_container_is_a_missing_step_under_strict() -> None:
    task = make_task("NEXT_TO character.65 fridge.10", "HOLDS_RH character.65 cup.13")
    assert both(task, plan("PUTIN cup.13 fridge.10")) == ("missing_step 0", "affordance 0")


def test_an_object_in_a_container_that_was_open_once_is_a_wrong_order_under_strict() -> None:
    text = plan("WALK fridge.10", "OPEN fridge.10", "CLOSE fridge.10", "GRAB milk.11")
    assert both(make_task(), text) == ("wrong_order 3", "missing_step 3")


def test_held_objects_come_along_under_strict() -> None:
    task = make_task("NEXT_TO character.65 book.16", goals=("relation INSIDE book.16 kitchen.1",))
    assert both(task, plan("GRAB book.16", "WALK kitchen.1")) == ("success", "failure")


def test_putting_back_can_fail_under_strict() -> None:
    task = make_task("NEXT_TO character.65 cup.13", goals=("relation ONTOP cup.13 table.12",))
    grab = "GRAB cup.13"
    assert both(task, plan(grab, "WALK bed.20", "PUTOBJBACK cup.13")) == ("wrong_order 2", "failure")
    assert both(task, plan(grab, "WALK table.12", "PUTOBJBACK cup.13")) == ("success", "success")


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
    assert both(make_task(), plan(step)) == (strict, "uncategorised 0")


def test_two_action_goals_count_in_their_order_under_strict() -> None:
    task = make_task(
        "NEXT_TO character.65 fridge.10",
        "-OFF fridge.10",
        "ON fridge.10",
        "NEXT_TO character.65 keyboard.23",
        goals=("action TYPE", "action SWITCHOFF"),
    )
    in_order = plan("TYPE keyboard.23", "SWITCHOFF fridge.10")
    reversed_order = plan("SWITCHOFF fridge.10", "TYPE keyboard.23")
    assert both(task, in_order) == ("success", "failure")
    assert both(task, reversed_order) == ("failure", "success")
    told_besides = counted(in_order, task)
    assert told_besides is not None
    assert (told_besides.success, told_besides.goals.action) == (True, (2, 2))
    assert told_besides.errors == {}
