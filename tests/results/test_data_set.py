"""Figures of data sets, also of a benchmark with only a declaration and two tasks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.packs import DataPack, fetch_packs
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.virtualhome.benchmark import compute_record_statistics_with_notes
from eai.benchmarks.virtualhome.records import PACK as VIRTUALHOME
from eai.benchmarks.virtualhome.records import VirtualHomeRecords, open_records
from eai.logic.formula import Constant, Exists, ForAll, Occurs, Variable
from eai.results.data_set import _DataSetStatistic, compute_data_set_statistics, profile_tasks
from eai.studies.report.distributions import make_task_property_distributions
from eai.tasks.goal_text import make_task
from eai.tasks.source import ErrataChoice, Source, use_tasks
from eai.world.action import Action
from oracle import read_shared
from world.toy import DOMAIN, at, initial, lit

BOX = Variable("box", "box")
HALL, SHED, LAMP, RED = (Constant(name) for name in ("hall", "shed", "lamp", "red"))

TIDY = replace(
    make_task(
        "tidy",
        "Bring all boxes into the hall.",
        initial(),
        ForAll(BOX, at(BOX, HALL)),
        at(RED, HALL),
        title="tidy up",
    ),
    script=(Action("GO", (2,)), Action("LIFT", (4,)), Action("GO", (1,)), Action("GO", (1,))),
)
SHOW = make_task("show", "Show a box.", initial(), Exists(BOX, at(BOX, SHED)), lit(LAMP), Occurs("PRESS", ()))
IDLE = make_task("idle", "Do nothing.", initial())
TOY = Benchmark("toy", DOMAIN, use_tasks(TIDY, SHOW, IDLE))


def test_profiles_have_the_features_of_a_task() -> None:
    tidy, show, idle = (each.table_row for each in profile_tasks(TOY, Source()))
    named = {
        "task": "tidy",
        "name": "tidy up",
        "annotated_steps": 4,
        "operators": "GO LIFT",
        "scene_objects": 6,
    }
    assert {name: tidy[name] for name in named} == named
    assert [tidy[name] for name in ("goals", "quantified_goals", "goals_at_start", "ground_goals")] == [
        2,
        1,
        1,
        3,
    ]
    assert [show[f"{kind}_goals"] for kind in ("state", "relation", "action")] == [1, 1, 1]
    assert [show[name] for name in ("goal_options", "annotated_steps", "operators")] == [2, None, ""]
    assert [idle[name] for name in ("goals", "asked_operators", "categories")] == [0, None, ""]


def test_any_benchmark_has_a_table() -> None:
    rows = compute_data_set_statistics(TOY, Source())
    values = {row.label: row.value for row in rows}
    assert all(row.printed is None and not row.remark for row in rows)
    assert {label: values[label] for label in ("tasks", "instructions", "goals", "goal conditions")} == {
        "tasks": 3,
        "instructions": 2,
        "goals": 6,
        "goal conditions": 5,
    }
    assert [values[label] for label in ("trajectories", "action steps", "transition models")] == [1, 4, 4]


def test_distributions_count_only_tasks_with_goals() -> None:
    found = {each.name: dict(each.counts) for each in make_task_property_distributions(TOY, Source())}
    assert found["annotated_steps"] == {4: 1}
    assert found["goal_options"] == {1: 1, 2: 1}
    assert found["actions"] == {"GO": 3, "LIFT": 1}
    assert found["pairs"] == {"GO place": 3, "LIFT box": 1}


def test_a_benchmark_without_plans_or_tasks_has_a_table_too() -> None:
    rows = {
        row.label: row.value
        for row in compute_data_set_statistics(Benchmark("none", DOMAIN, use_tasks()), Source())
    }
    assert rows["tasks"] == rows["trajectories"] == rows["goals"] == 0
    assert "action steps" not in rows
    assert make_task_property_distributions(Benchmark("none", DOMAIN, use_tasks()), Source()) == ()


NOT_AS_PRINTED = {
    "virtualhome": {"percent longer than 10", "tasks: object affordance", "tasks: object orientation"},
    "behavior": {"action steps"},
}
"""The figures of the paper that do not come out, each with a remark that says why."""


def rows_of(domain: str, store: DataPackStore) -> dict[str, _DataSetStatistic]:
    return {row.label: row for row in compute_data_set_statistics(find_benchmark(domain), Source(store))}


def test_annotated_records_are_counted(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    fetch_packs(store, packs=packs)
    figures = compute_record_statistics_with_notes(
        VirtualHomeRecords.from_pack(store.open_pack(VIRTUALHOME)), ["1_1"], 5
    )
    assert {label: value for label, (value, _) in figures.items()} == {
        "task names": 2,
        "tasks": 3,
        "instructions": 2,
        "action sequencing tasks": 2,
        "transition modeling tasks": 1,
        "goals": 5,
        "state goals": 1,
        "relation goals": 2,
        "action goals": 2,
        "action steps": 4,
        "transition models": 5,
    }
    assert "Put cup (1)" in figures["transition modeling tasks"][1]


@pytest.mark.parametrize("domain", ["virtualhome", "behavior"])
def test_every_figure_of_the_paper_is_reproduced_or_has_a_remark(
    data_store: DataPackStore, domain: str
) -> None:
    rows = rows_of(domain, data_store)
    printed = {label: row for label, row in rows.items() if row.printed is not None}
    differing = {
        label for label, row in printed.items() if round(row.value, decimals(row.printed)) != row.printed
    }
    assert differing == NOT_AS_PRINTED[domain]
    assert all(rows[label].remark for label in differing)


def decimals(printed: float | None) -> int:
    return len(str(printed).partition(".")[2])


def test_the_figures_in_the_papers_column_are_as_printed(data_store: DataPackStore) -> None:
    found = read_shared("paper", "dataset_statistics.json")
    label_of = {
        "steps": "action steps",
        "steps_mean": "steps per trajectory",
        "steps_min": "fewest steps",
        "steps_max": "most steps",
        "share_of_instructions_longer_than_10": "percent longer than 10",
        "task_names_with_an_instruction_longer_than_10": "names with one longer than 10",
        "goal_conditions_mean": "goal conditions per task",
        "ground_goals_mean": "ground goals per task",
        "goal_options_mean": "goal options per task",
    }
    for column, domain in enumerate(found["columns"]):
        rows = rows_of(domain, data_store)
        expected = {
            label_of.get(name, name.replace("_", " ")): figures[column]
            for name, figures in found["rows"].items()
            if figures[column] is not None
        }
        if domain == "virtualhome":
            expected["percent longer than 10"] = round(100 * expected["percent longer than 10"])
        of_categories = read_shared("paper", "task_categories.json")["rows_as_printed"]
        for name, figures in of_categories.items():
            if figures[column] is not None:
                expected[f"tasks: {name.replace('non_', 'non-').replace('_', ' ')}"] = figures[column]
        assert {label: row.printed for label, row in rows.items() if row.printed is not None} == expected


def test_figures_that_the_paper_lacks_are_counted(data_store: DataPackStore) -> None:
    virtualhome, behavior = rows_of("virtualhome", data_store), rows_of("behavior", data_store)
    assert {
        label: virtualhome[label].value
        for label in ("tasks", "action sequencing tasks", "transition modeling tasks", "goal conditions")
    } == {
        "tasks": 342,
        "action sequencing tasks": 305,
        "transition modeling tasks": 296,
        "goal conditions": 800,
    }
    assert "less the 37 with two or more" in virtualhome["action sequencing tasks"].note
    assert [virtualhome[f"tasks: object {name}"].value for name in ("affordance", "orientation")] == [167, 28]
    assert {
        label: behavior[label].value
        for label in ("goal conditions", "goal options per task", "goal options, median", "most steps")
    } == {
        "goal conditions": 366,
        "goal options per task": 4164.41,
        "goal options, median": 1,
        "most steps": 67,
    }


def test_remarks_on_figures_are_true(data_store: DataPackStore) -> None:
    scripts = [task.script for task in open_records(Source(data_store)).values()]
    goals = profile_tasks(find_benchmark("virtualhome"), Source(data_store))
    instructed = [script for script, task in zip(scripts, goals, strict=True) if task.features.goals]
    assert round(100 * sum(len(script) >= 10 for script in instructed) / len(instructed), 1) == 38.2
    tasks = profile_tasks(find_benchmark("behavior"), Source(data_store, errata=ErrataChoice.NONE))
    options = [task.features.goal_options for task in tasks]
    assert round(max(options) / sum(options), 1) == 0.8
    lists = read_shared("paper", "task_lists.json")["behavior_plan_length"]
    released = {each.task.title: each.features.annotated_steps for each in tasks}
    assert len(lists) == 60
    assert {name: (steps, released[name]) for name, steps in lists.items() if released[name] != steps} == {
        "cleaning_bathrooms": (12, 11)
    }


def test_four_tasks_have_neither_goals_nor_a_temporal_goal(data_store: DataPackStore) -> None:
    tasks = open_records(Source(data_store)).values()
    assert {task.id for task in tasks if task.tl_goal is None} == {"627_1", "339_1", "84_1", "93_1"}
    assert all(
        (task.tl_goal is None) == (not (task.node_goals or task.edge_goals or task.action_goals))
        for task in tasks
    )


def test_goal_options_by_decade_equal_the_papers_figure(data_store: DataPackStore) -> None:
    found = {
        each.name: each
        for each in make_task_property_distributions(
            find_benchmark("behavior"), Source(data_store, errata=ErrataChoice.NONE)
        )
    }
    decades = [
        sum(count for value, count in found["goal_options"].counts.items() if len(str(value)) == digits)
        for digits in range(1, 7)
    ]
    assert decades == [82, 7, 7, 1, 2, 1]
    assert sum(found["annotated_steps"].counts.values()) == 100
    assert sum(found["actions"].counts.values()) == 1455
    assert all(list(each.counts) == sorted(each.counts) for each in found.values() if each.unit == "tasks")
