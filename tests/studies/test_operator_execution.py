"""Plans that a planner finds with operators of answers, carried out in the world."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from command_line import Command
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.transition_modeling.verdict import OperatorVerdict
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import open_suite
from eai.pddl.planning import PlannerChoice
from eai.studies.pipeline.operator_execution import (
    CONDITIONS_MISSED,
    ONLY_ACTIONS_MISSED,
    SUCCESS,
    UNTRANSLATED,
    OperatorTestOutcome,
    _OperatorTesterByPlanExecution,
)
from eai.tasks.source import Source
from results.verdicts import record
from studies.report.samples import write_runs
from studies.told import read_table
from suites import answer_book

FOOD = "703_2"
"""The task of food in the freezer: walk_towards, open, grab, put_inside."""
DOORS = "locking_every_door_0_Merom_1_int_0_2021-10-20_05-53-14"
FAX = "installing_a_fax_machine_0_Beechwood_0_int_0_2021-10-25_20-22-22"
BASKETS = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"
LUNCHES = "packing_lunches_0_Beechwood_0_int_0_2021-10-26_11-03-14"

IS_OPEN = " (open ?obj2)"
EVERYTHING = "(forall (?x - object) (forall (?y - object) (obj_inside ?x ?y)))"


def operators(name: str, store: DataPackStore, task_id: str) -> str:
    """The data set's operators of a task."""
    text = answer_book(name, Ability.TRANSITION_MODELING, store)[task_id].text
    return str(json.loads(text)["output"])


def find_outcome(
    name: str,
    store: DataPackStore,
    task_id: str,
    written: str,
    planner: PlannerChoice = PlannerChoice.BUILT_IN,
) -> OperatorTestOutcome | None:
    """The outcome of the test of operators, as an answer that scoring judges first."""
    tester = _OperatorTesterByPlanExecution.open_operator_tester(name, Source(store, planner=planner))
    answer = json.dumps({"output": written})
    verdict = tester.operators.score(task_id, answer)
    assert isinstance(verdict, OperatorVerdict)
    return tester.find_failed_stage_and_reason(task_id, answer, verdict)


@pytest.mark.parametrize(
    ("name", "task_id", "expected"),
    [
        ("virtualhome", FOOD, SUCCESS),
        ("virtualhome", "600_1", ONLY_ACTIONS_MISSED),
        ("virtualhome", "201_1", ("execution", "affordance")),
        ("virtualhome", "696_1", ("execution", "wrong_order")),
        ("virtualhome", "688_1", None),
        ("behavior", DOORS, SUCCESS),
        ("behavior", FAX, UNTRANSLATED),
        ("behavior", BASKETS, ("execution", "affordance")),
        ("behavior", LUNCHES, CONDITIONS_MISSED),
    ],
)
def test_the_true_operators_succeed_or_fail_at_a_stage(
    data_store: DataPackStore, name: str, task_id: str, expected: OperatorTestOutcome | None
) -> None:
    assert find_outcome(name, data_store, task_id, operators(name, data_store, task_id)) == expected
    tester = _OperatorTesterByPlanExecution.open_operator_tester(
        name, Source(data_store, planner=PlannerChoice.BUILT_IN)
    )
    assert tester.find_outcome_of_gold_operator_test(task_id) == expected


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("", "", SUCCESS),
        ("?obj1", "?thing", SUCCESS),
        ("(:action open", "(:action (open", ("operators", "parsing")),
        ("(can_open ?obj)", "(is_lovely ?obj)", ("operators", "input_error")),
        (":effect (and (open ?obj)", ":effect (and (on ?obj)", ("planner", "unsolvable")),
        (
            "walk_towards :parameters (?char - character ?obj - object)",
            "walk_towards :parameters (?obj - object ?char - character ?more - object)",
            SUCCESS,
        ),
        (IS_OPEN, "", ("execution", "missing_step")),
        ("(obj_inside ?obj1 ?obj2)", "(obj_inside ?obj2 ?obj1)", ("planner", "unsolvable")),
        ("(and (next_to ?char ?obj) (forall", f"(and {EVERYTHING} (forall", CONDITIONS_MISSED),
    ],
)
def test_a_damaged_operator_fails_at_the_stage_that_it_damages(
    data_store: DataPackStore, old: str, new: str, expected: OperatorTestOutcome
) -> None:
    written = operators("virtualhome", data_store, FOOD)
    assert old in written
    assert find_outcome("virtualhome", data_store, FOOD, written.replace(old, new)) == expected


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("(open ?obj) (not (handsfull ?agent))", "(open ?obj)", SUCCESS),
        ("(not (open ?obj))", "(open ?obj)", ("planner", "unsolvable")),
        ("(?obj - object ?agent - agent)", "(?thing - object)", UNTRANSLATED),
    ],
)
def test_a_damaged_operator_of_behavior_fails(
    data_store: DataPackStore, old: str, new: str, expected: OperatorTestOutcome
) -> None:
    written = operators("behavior", data_store, DOORS)
    assert old in written
    changed = written.replace(old, new)
    if "?thing" in new:
        changed = changed.replace("?obj)", "?thing)").replace(" (not (handsfull ?agent))", "")
    assert find_outcome("behavior", data_store, DOORS, changed) == expected


def test_operators_without_a_planner_have_no_outcome(data_store: DataPackStore) -> None:
    written = operators("virtualhome", data_store, FOOD)
    assert find_outcome("virtualhome", data_store, FOOD, written, PlannerChoice.NONE) is None


@pytest.mark.parametrize("answer", ["", '{"output": "(:action fly :parameters () :effect ())"}'])
def test_a_plan_of_operators_that_the_answer_does_not_have_is_refused(
    data_store: DataPackStore, answer: str
) -> None:
    tester = _OperatorTesterByPlanExecution.open_operator_tester(
        "virtualhome", Source(data_store, planner=PlannerChoice.BUILT_IN)
    )
    text = answer_book("virtualhome", Ability.TRANSITION_MODELING, data_store)[FOOD].text
    verdict = tester.operators.score(FOOD, text)
    assert isinstance(verdict, OperatorVerdict)
    with pytest.raises(InputError, match=rf"task {FOOD}: the plan in the record .* score the answer again"):
        tester.find_failed_stage_and_reason(FOOD, answer, verdict)


def test_the_analysis_counts_outcomes_of_answers_and_of_true_operators(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    ability = Ability.TRANSITION_MODELING
    source = Source(data_store, planner=PlannerChoice.BUILT_IN)
    suite = open_suite("virtualhome", ability, source=source)
    answers = {
        FOOD: operators("virtualhome", data_store, FOOD).replace(IS_OPEN, ""),
        "600_1": operators("virtualhome", data_store, "600_1"),
        "688_1": operators("virtualhome", data_store, "688_1"),
    }
    texts = {task_id: json.dumps({"output": text}) for task_id, text in answers.items()}
    run = [
        record(task_id, suite.score(task_id, text), ability=ability, response=text)
        for task_id, text in texts.items()
    ]
    under_another_protocol = [replace(each, protocol=[*Protocol.list_names()][-1]) for each in run]
    runs = write_runs(tmp_path / "runs", [run, under_another_protocol])
    outcome = eai("analyze", "pipeline", runs, "--out", tmp_path / "out")
    assert outcome.status == 0, outcome.err
    assert "left out, because operators are only executed under strict: m, virtualhome" in outcome.err
    rows = read_table(tmp_path / "out" / "operators.csv")
    columns = ("breaks at", "reason", "share_numerator", "share_denominator", "true operators_numerator")
    assert [tuple([row[column] for column in columns]) for row in rows] == [
        ("execution", "missing_step", "1", "2", "0"),
        ("goal", "only_actions", "1", "2", "1"),
        ("nowhere", "", "0", "2", "1"),
    ]
