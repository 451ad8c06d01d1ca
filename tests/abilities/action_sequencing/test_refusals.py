"""Refusals: an answer may call a task impossible if the task allows it, and is right if no plan exists."""

from __future__ import annotations

from dataclasses import replace

import pytest

import eai
from agents.switches import DOMAIN, as_plan, initial
from eai import Benchmark, Reward, Shaping, Suite, Task, make_task, use_tasks
from eai.abilities.declining import QUESTION, read_refusal_reason, write_refusal_answer
from eai.abilities.repair import DEFAULT_EFFORT
from eai.abilities.verdict import PlanVerdict
from eai.agents.game import Game
from eai.agents.reference import make_setup
from eai.agents.rules import TRAINING
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.batch import score_run
from eai.results.codec import record_from_json, record_to_json
from eai.results.options import ScoringOptions
from eai.results.responses import Response, ResponseFile
from eai.tasks.prompts.own import explain_goal_notation
from eai.tasks.prompts.template import PromptTemplates
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark

WHY = "lit(lamp)"
NO = write_refusal_answer(WHY)


def world(**changes: object) -> Benchmark:
    task = make_task("t", "Light the lamp.", initial(), "lit(lamp)", domain=DOMAIN)
    return Benchmark("switches", DOMAIN, use_tasks(replace(task, **changes)))  # type: ignore[arg-type]


def suite(**changes: object) -> Suite:
    return eai.open(world(**changes), "action_sequencing")


def verdict_on(text: str, **changes: object) -> PlanVerdict:
    verdict = suite(**changes).score("t", text)
    assert isinstance(verdict, PlanVerdict)
    return verdict


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (NO, WHY),
        (f"Let me think.\n```json\n{NO}\n```", WHY),
        (f"{NO} But then: {as_plan(['PRESS(lamp)'])}", None),
        (f"{as_plan(['PRESS(lamp)'])} No: {NO}", WHY),
        ('{"impossible": 3}', None),
        ('{"impossible": "a", "plan": []}', None),
        ('{"PRESS": ["lamp"]}', None),
        ("It is impossible.", None),
        ("", None),
    ],
)
def test_the_last_json_value_decides_on_a_refusal(text: str, reason: str | None) -> None:
    assert read_refusal_reason(text) == reason


def test_a_refusal_is_right_if_facts_are_missing() -> None:
    right = verdict_on(NO, special=PossiblyImpossibleTaskMark((WHY,)))
    false = verdict_on(NO, special=PossiblyImpossibleTaskMark(()))
    assert (right.success, right.refused, right.error) == (True, WHY, None)
    assert (false.success, false.refused, false.error) == (False, WHY, None)
    assert not any(right.goals_satisfied)
    notes = suite(special=PossiblyImpossibleTaskMark((WHY,))).scorer("t").explain(NO).notes
    assert f"missing: {WHY}" in notes


def test_a_refusal_is_read_only_if_the_task_allows_it() -> None:
    plain = verdict_on(NO)
    assert plain.refused is None
    assert plain.error is not None
    assert "impossible" not in "".join(_told())
    assert "impossible" in "".join(_told(special=PossiblyImpossibleTaskMark(())))
    assert _told(special=PossiblyImpossibleTaskMark(())) == _told(
        special=PossiblyImpossibleTaskMark((WHY,))
    ), "the prompt does not say which it is"


def _told(**changes: object) -> list[str]:
    task = suite(**changes).tasks["t"]
    assert isinstance(task, Task)
    return explain_goal_notation("action_sequencing", [task], PromptTemplates())


def test_a_plan_is_scored_even_if_a_refusal_is_allowed() -> None:
    assert verdict_on(as_plan(["PRESS(lamp)"]), special=PossiblyImpossibleTaskMark(())).success


def test_the_gold_refusal_names_the_missing_facts_and_is_paid_in_full() -> None:
    for missing, paid in (((WHY,), 1.0), ((), 0.0)):
        asked = world(special=PossiblyImpossibleTaskMark(missing))
        opened = eai.open(asked, "action_sequencing")
        assert {Reward(opened, shaping)("t", NO) for shaping in ("success", "goals", "progress")} == {paid}
        gold = open_gold_answers(asked, opened.ability)["t"].text
        assert Reward(opened)("t", gold) == 1.0
        assert (gold == NO) == bool(missing)


def test_a_plan_for_an_impossible_task_earns_nothing() -> None:
    asked = world(special=PossiblyImpossibleTaskMark((WHY,)))
    opened = eai.open(asked, "action_sequencing")
    plan = as_plan(["PRESS(lamp)"])
    assert {Reward(opened, shaping)("t", plan) for shaping in Shaping} == {0.0}
    assert Reward(opened, Shaping.REPAIR)("t", NO) == 1.0
    assert (
        Reward(eai.open(world(special=PossiblyImpossibleTaskMark(())), "action_sequencing"), Shaping.REPAIR)(
            "t", NO
        )
        == 0.0
    )
    task = opened.tasks["t"]
    assert isinstance(task, Task)
    for shaping in Shaping:
        game = Game(make_setup(task, asked, TRAINING.model_copy(update={"reward": shaping})))
        assert (game.act("PRESS(lamp)").reward, game.reward_if_ended_now) == (0.0, 0.0)


def test_an_answer_with_a_plan_and_a_refusal_is_paid_for_the_last() -> None:
    plan, ask = as_plan(["PRESS(lamp)"]), write_refusal_answer("Which?", QUESTION)
    for text, special, is_right in [
        (f"{plan} {NO}", PossiblyImpossibleTaskMark(()), False),
        (f"{plan} {NO}", PossiblyImpossibleTaskMark((WHY,)), True),
        (f"{plan} {ask}", AmbiguousTaskMark(("lamp",)), False),
        (f"{plan} {ask}", AmbiguousTaskMark(("lamp", "torch")), True),
        (ask, AmbiguousTaskMark(("lamp", "torch")), True),
    ]:
        opened = suite(special=special)
        assert {Reward(opened, shaping)("t", text) for shaping in Shaping} == {float(is_right)}
        look_back = opened.scorer("t").assess(text).analyze_failure
        assert look_back is not None
        repair = look_back(DEFAULT_EFFORT).repair
        assert repair is not None
        assert repair.distance == (0 if is_right else None)


def test_a_record_keeps_the_refusal_and_no_repair_is_searched() -> None:
    opened = suite(special=PossiblyImpossibleTaskMark((WHY,)))
    for text, why in ((NO, None), (as_plan(["PRESS(lamp)", "PRESS(torch)"]), "unsolvable")):
        (record,) = score_run(opened, ResponseFile("m", (Response("t", text),)), {}, ScoringOptions())
        values = record_to_json(record)
        assert record_from_json(values) == record
        assert ("refused" in values) == (text == NO)
        assert record.task is not None
        assert record.task.missing == (WHY,)
        look_back = opened.scorer("t").assess(text).analyze_failure
        if look_back is not None and why is not None:
            repair = look_back(DEFAULT_EFFORT).repair
            assert repair is not None
            assert repair.why_null in (None, why)


def test_records_of_other_tasks_do_not_mention_refusals() -> None:
    (record,) = score_run(suite(), ResponseFile("m", (Response("t", NO),)), {}, ScoringOptions())
    values = record_to_json(record)
    task = values["task"]
    assert isinstance(task, dict)
    assert {"refused"}.isdisjoint(values)
    assert {"hazards", "missing"}.isdisjoint(task)
