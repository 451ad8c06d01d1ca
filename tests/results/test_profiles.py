"""Figures of a benchmark that is nothing but a declaration and two tasks."""

from __future__ import annotations

from dataclasses import replace

from eai.abilities.task import make_task
from eai.benchmark.benchmark import Benchmark
from eai.logic.formula import Constant, Exists, ForAll, Occurs, Variable
from eai.results.data_set import distributions, profiles_of, table_of
from eai.tasks.source import Source, given
from eai.world.execution import Action
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
TOY = Benchmark("toy", DOMAIN, given(TIDY, SHOW, IDLE))


def test_profiles_say_what_a_task_is_like() -> None:
    tidy, show, idle = (each.to_json() for each in profiles_of(TOY, Source()))
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
    rows = table_of(TOY, Source())
    values = {row.label: row.value for row in rows}
    assert all(row.printed is None and not row.remark for row in rows)
    assert {label: values[label] for label in ("tasks", "instructions", "goals", "goal conditions")} == {
        "tasks": 3,
        "instructions": 2,
        "goals": 6,
        "goal conditions": 5,
    }
    assert [values[label] for label in ("trajectories", "action steps", "transition models")] == [1, 4, 4]


def test_distributions_are_of_tasks_with_goals() -> None:
    found = {each.name: dict(each.counts) for each in distributions(TOY, Source())}
    assert found["annotated_steps"] == {4: 1}
    assert found["goal_options"] == {1: 1, 2: 1}
    assert found["actions"] == {"GO": 3, "LIFT": 1}
    assert found["pairs"] == {"GO place": 3, "LIFT box": 1}


def test_a_benchmark_without_plans_or_tasks_has_a_table_too() -> None:
    rows = {row.label: row.value for row in table_of(Benchmark("none", DOMAIN, given()), Source())}
    assert rows["tasks"] == rows["trajectories"] == rows["goals"] == 0
    assert "action steps" not in rows
    assert distributions(Benchmark("none", DOMAIN, given()), Source()) == ()
