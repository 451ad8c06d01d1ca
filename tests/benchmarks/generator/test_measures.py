"""Measures of tasks and certificates, by hand-written tasks of both households."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib import resources

import pytest

import eai.logic.formula as f
from agents.switches import SWITCHES
from benchmarks.generator.worlds import HOUSEHOLDS, tasks
from by_path import module_at
from eai.base.errors import InputError
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.measures import (
    FILE,
    TaskMeasure,
    _DifficultyModel,
    _PredicateShowingOrHidingContents,
    find_predicates_showing_or_hiding_contents,
    get_difficulty_model,
    make_formula_that_object_x_exists,
    measure_task,
)
from eai.benchmarks.generator.spec import TaskSpecification
from eai.benchmarks.registry import find_benchmark
from eai.tasks.goal_text import make_task
from eai.tasks.source import Source
from eai.world.action import Action
from eai.world.state import Fact, Scene, WorldObject

_MEASURED = (TaskMeasure.CONTAINERS, TaskMeasure.HIDDEN, TaskMeasure.TOOL_STEPS, TaskMeasure.DISTRACTORS)


def test_absent_objects_are_distinguished_from_hidden_ones() -> None:
    household = {like: make_formula_that_object_x_exists(find_benchmark(like).domain) for like in HOUSEHOLDS}
    part, sliced = f.Atom("part", (f.Variable("x"),)), f.Atom("is_sliced", (f.Variable("x"),))
    assert household == {"behavior": f.And((~part | sliced,)), "virtualhome": f.TRUE}
    near = replace(SWITCHES.domain, visible=f.Atom("beside", (f.Variable("x"),)))
    assert (
        make_formula_that_object_x_exists(near)
        == make_formula_that_object_x_exists(SWITCHES.domain)
        == make_formula_that_object_x_exists(replace(near, visible=None))
        == f.TRUE
    )


def test_lids_follow_from_the_declared_visibility() -> None:
    told = {
        like: set(find_predicates_showing_or_hiding_contents(find_benchmark(like).domain))
        for like in HOUSEHOLDS
    }
    assert told == {
        "virtualhome": {_PredicateShowingOrHidingContents("CLOSED", False)},
        "behavior": {_PredicateShowingOrHidingContents("is_open", True)},
    }


@pytest.mark.parametrize(
    ("plan", "expected"),
    [
        # An apple, a knife in a shut container that cuts it, and an irrelevant pear.
        ("OPEN cabinet; LEFT_GRASP knife; SLICE apple", (1, 1, 1, 2)),
        # An empty box is opened too.
        ("OPEN cabinet; OPEN box; LEFT_GRASP knife; SLICE apple", (2, 1, 1, 1)),
        # The plan shuts an open container, which reveals nothing.
        ("OPEN cabinet; LEFT_GRASP knife; CLOSE cabinet; SLICE apple", (1, 1, 1, 2)),
        ("RIGHT_GRASP apple", (0, 0, 0, 4)),
    ],
)
def test_containers_hidden_things_and_tools_of_a_plan(plan: str, expected: tuple[int, ...]) -> None:
    domain = find_benchmark("behavior").domain
    things = {
        "apple": "apple.n.01",
        "knife": "carving_knife.n.01",
        "cabinet": "cabinet.n.01",
        "box": "box.n.01",
        "pear": "pear.n.01",
    }
    names = list(things)
    scene = Scene(domain.vocabulary, [WorldObject(name, kind) for name, kind in things.items()], None)
    facts = [
        Fact("sliceable", (0,)),
        Fact("slicer", (1,)),
        Fact("openable", (2,)),
        Fact("openable", (3,)),
        Fact("lies_in", (1, 2)),
    ]
    steps = [
        Action(name, tuple([names.index(each) for each in about]))
        for name, *about in (step.split() for step in plan.split("; "))
    ]
    goal = f.Atom("sliced", (f.Constant("apple"),))
    task = replace(make_task("t", "-", scene.state(facts), goal), script=tuple(steps))
    found = measure_task(task, domain)
    assert tuple(found[each] for each in _MEASURED) == expected


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_all_that_is_measured_is_recorded(like: str) -> None:
    for made in tasks(like):
        found = measure_task(made.task, find_benchmark(like).domain)
        assert {each.value: made.about[each.value] for each in TaskMeasure} == found
        assert found[TaskMeasure.STEPS] == len(made.task.script)


pytestmark = pytest.mark.usefixtures("data_store")


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_generated_tasks_say_how_difficult_they_are_expected_to_be(like: str) -> None:
    model = get_difficulty_model(like)
    assert model is not None
    for made in tasks(like, 12):
        task = made.task
        log_steps, log_goals = math.log(len(task.script)), math.log(1 + len(task.goals))
        operators = len({action.operator for action in task.script})
        steps, kinds, goals = model.weights
        value = model.intercept + steps * log_steps + kinds * operators + goals * log_goals
        assert made.about["difficulty"] == {"expected": round(value, 2), "error": model.error}


def test_longer_plans_and_more_goals_are_harder() -> None:
    model = _DifficultyModel(-2.0, (1.0, 0.1, 0.5), 1.4, 0.4, 0.6)
    task = tasks("virtualhome", 12)[0].task
    found = model.estimate_difficulty(task)
    longer = model.estimate_difficulty(replace(task, script=task.script * 2))
    assert found is not None
    assert longer is not None
    assert longer == pytest.approx(found + math.log(2), abs=0.011)
    assert model.estimate_difficulty(replace(task, script=())) is None


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_coefficients_are_those_of_the_public_tasks(like: str) -> None:
    pytest.importorskip("scipy")
    pytest.importorskip("eai.extensions.adaptive")
    tool = module_at("tools/task_difficulty.py")
    known = json.loads((resources.files("eai.benchmarks.generator") / FILE).read_text(encoding="utf-8"))[like]
    fitted = tool.fit(like)
    assert fitted["weights"] == pytest.approx(known["weights"], abs=0.002)
    assert {**fitted, "weights": 0} == pytest.approx({**known, "weights": 0}, abs=0.011)


def test_a_world_without_public_answers_has_no_difficulties() -> None:
    assert get_difficulty_model("lamps") is None
    benchmark, source = replace(find_benchmark("behavior"), name="another"), Source()
    with pytest.raises(InputError, match=r"the difficulty of tasks of .* is not known"):
        TaskGenerator(benchmark, TaskSpecification("behavior", "", difficulty=(0.0, 1.0)), source)
