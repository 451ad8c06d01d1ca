"""Pipelines through Inspect: its tasks state the goals of answers, and its logs have the same records."""

from __future__ import annotations

import json
from collections.abc import Iterator
from concurrent.futures import Executor
from pathlib import Path

import pytest
from inspect_ai.log import read_eval_log

from eai.abilities.protocol import Ability, Protocol
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.run.registry import TASKS
from processes import own_process
from run.child import Asked, Whom, evaluate_experiment_in_child, score_in_child
from suites import answer_book

PLANS = Ability.ACTION_SEQUENCING
BOOKS = "boxing_books_up_for_storage_0_Benevolence_1_int_0_2021-09-10_15-35-47"
JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"


@pytest.fixture(scope="module")
def process() -> Iterator[Executor]:
    """A process of its own for Inspect."""
    with own_process() as pool:
        yield pool


@pytest.fixture
def goals(data_store: DataPackStore, tmp_path: Path) -> Path:
    """Right goals for one task, and meaningless ones for another."""
    gold = answer_book("behavior", Ability.GOAL_INTERPRETATION, data_store)
    rows = [
        {"identifier": BOOKS, "llm_output": gold[BOOKS].text},
        {"identifier": JARS, "llm_output": '{"node goals": [["eaten", "peach.n.03_1"]]}'},
    ]
    file = tmp_path / "some-model_outputs.json"
    file.write_text(json.dumps(rows), encoding="utf-8")
    return file


def test_a_task_states_the_goals_of_answers(goals: Path) -> None:
    make = TASKS["behavior_action_sequencing"]
    (sample,) = make(goals=str(goals), tasks=[JARS]).dataset
    assert isinstance(sample.input, list)
    assert "target environment state:\n['eaten', 'peach_0']\n" in sample.input[-1].text
    for wrong, message in (
        ({"tasks": None}, "98 of 100 tasks cannot be asked: there is no answer to goal interpretation"),
    ):
        with pytest.raises(InputError, match=message):
            make(goals=str(goals), **wrong)
    with pytest.raises(InputError, match="questions of goal_interpretation state no goals"):
        TASKS["behavior_goal_interpretation"](goals=str(goals))


def test_records_of_a_log_name_the_source_of_their_goals(
    goals: Path, process: Executor, tmp_path: Path
) -> None:
    """The planner reaches the stated goals; scoring the log again changes nothing."""
    asked = Asked("behavior", PLANS, Protocol.STRICT, [BOOKS, JARS])
    told = {"goals": str(goals)}
    whom = Whom("eai/planner", {})
    path = process.submit(evaluate_experiment_in_child, asked, whom, tmp_path, told).result()
    scored = process.submit(score_in_child, path, asked).result()
    for log in (read_eval_log(path), read_eval_log(scored)):
        records = {
            str(sample.id): (sample.scores or {})[PLANS.value].metadata or {} for sample in log.samples or ()
        }
        assert {task: record["success"] for task, record in records.items()} == {BOOKS: True, JARS: False}
        parts = {task: record["study"]["pipeline"] for task, record in records.items()}
        assert {each["label"] for each in parts.values()} == {"goals-some-model"}
        assert parts[BOOKS]["summary"]["goal_counts"] == [7, 0, 0]
        assert parts[JARS]["summary"]["stage_1_unknown"] == ["eaten"]
