from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from cli.test_analyze import must_have_the_same_bytes
from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.extensions.adaptive.flag import Flag
from eai.extensions.adaptive.item_flags import make_function_that_flags_doubtful_tasks
from eai.extensions.adaptive.study import make_task_difficulty_tables
from eai.planning.planner import Planner
from eai.planning.search import SearchResult
from eai.results.lines import SuiteKey
from eai.results.table import Table
from eai.tasks.source import Source
from eai.world.action import Action
from oracle import MODELS
from studies.published import tables

pytest.importorskip("scipy")

SUBGOALS = SuiteKey("eai-1.0.5", "virtualhome", "subgoal_decomposition")
PLANS = SuiteKey("eai-1.0.5", "virtualhome", "action_sequencing")
WRONG_GOLD = "cleaning_high_chair_0_Wainscott_0_int_0_2021-06-05_18-03-15"


def unflagged(suite: SuiteKey, task: str, unsolved: bool) -> Iterator[Flag]:
    if unsolved:
        yield "unsolved"


def rows(table: Table) -> list[dict[str, Any]]:
    return table.row_dicts()


@pytest.fixture(scope="module")
def nine() -> dict[str, list[dict[str, Any]]]:
    answers = tables("behavior", Ability.ACTION_SEQUENCING, MODELS).answers
    return {table.name: rows(table) for table in make_task_difficulty_tables(answers, unflagged)}


def test_the_table_of_tests_counts_the_tasks_of_a_suite(nine: dict[str, list[dict[str, Any]]]) -> None:
    (suite,) = nine["tests"]
    counts = [suite[name] for name in ("models", "tasks", "saturated", "unsolved", "negative")]
    assert counts == [9, 100, 9, 25, 4]
    assert round(suite["alpha"], 3) == 0.968
    assert suite["held_out_rasch"] > 0.9 > 0.75 > suite["held_out_mean"]


def test_null_models_are_left_out_of_item_tables() -> None:
    answers = tables("behavior", Ability.ACTION_SEQUENCING, MODELS[:4]).answers
    known = [each for each in answers if each.model == MODELS[0]]
    assert known
    more = [*answers, *(replace(each, model="eai_copy") for each in known)]
    assert [table.rows for table in make_task_difficulty_tables(more, unflagged)] == [
        table.rows for table in make_task_difficulty_tables(answers, unflagged)
    ]


def test_models_are_sorted_by_ability_and_score(
    nine: dict[str, list[dict[str, Any]]],
) -> None:
    scores = [row["score"].value for row in nine["abilities"]]
    assert scores == sorted(scores, reverse=True)
    assert all(row["logit"].low < row["logit"].value < row["logit"].high for row in nine["abilities"])


def test_tasks_are_flagged_by_who_solves_them(nine: dict[str, list[dict[str, Any]]]) -> None:
    for row in nine["items"]:
        flags = row["flags"].split(", ")
        assert ("unsolved" in flags) == (row["solved"] == 0)
        assert ("saturated" in flags) == (row["solved"] >= 8)
    hardest = max(nine["items"], key=lambda row: row["difficulty"])
    assert hardest["solved"] == 0
    assert len(nine["flagged"]) == 29


@pytest.mark.parametrize(
    ("suite", "task", "unsolved", "flags"),
    [
        (PLANS, "120_1", True, ["unsolved: plan exists", "ambiguous names"]),
        (PLANS, "120_1", False, ["ambiguous names"]),
        (PLANS, "26_1", True, ["unsolved: plan exists"]),
        (SUBGOALS, "689_1", True, ["unsolved: plan exists"]),
        (SUBGOALS, "26_1", True, ["unsolved"]),
        (PLANS._replace(ability="goal_interpretation"), "26_1", True, ["unsolved"]),
        (PLANS._replace(domain="elsewhere"), "26_1", True, ["unsolved"]),
        (PLANS, "27_2", False, []),
    ],
)
def test_the_planner_tries_tasks_that_no_model_solves(
    suite: SuiteKey,
    task: str,
    unsolved: bool,
    flags: list[Flag],
    data_store: DataPackStore,
) -> None:
    """In 26_1 the character sits, and under eai-1.0.5 no subgoal makes it stand up."""
    assert list(make_function_that_flags_doubtful_tasks(Source(data_store))(suite, task, unsolved)) == flags


def test_a_gold_answer_that_is_right_proves_a_plan_without_a_search(
    data_store: DataPackStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The gold answer of one task is wrong in the reference package, so a plan is searched for it."""
    searched = []

    def search(self: Planner, *args: Any, **kwargs: Any) -> SearchResult[Action]:
        searched.append(args)
        return plan(self, *args, **kwargs)

    plan = Planner.find_plan
    monkeypatch.setattr(Planner, "find_plan", search)
    flags = make_function_that_flags_doubtful_tasks(Source(data_store))
    for protocol, looks in (("strict", 0), ("eai-1.0.5", 1)):
        suite = SuiteKey(protocol, "behavior", "subgoal_decomposition")
        assert list(flags(suite, WRONG_GOLD, True)) == ["unsolved: plan exists"]
        assert len(searched) == looks


def test_eight_tasks_ask_for_two_lights_of_one_name(data_store: DataPackStore) -> None:
    from eai.benchmarks.registry import find_benchmark

    flags = make_function_that_flags_doubtful_tasks(Source(data_store))
    tasks = find_benchmark("virtualhome").tasks(Source(data_store))
    ambiguous = [task for task in tasks if "ambiguous names" in flags(PLANS, task, False)]
    assert len(ambiguous) == 8


def test_the_analysis_has_the_same_bytes_each_time(eai: Command, tmp_path: Path) -> None:
    must_have_the_same_bytes(eai, tmp_path, "items")
