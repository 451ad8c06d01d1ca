"""Expected difficulties: what they are made of, and that the coefficients are those that the tool fits."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib import resources
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from eai.benchmark.registry import find_benchmark
from eai.errors import InputError
from eai.generator.difficulty import FILE, DifficultyModel, difficulty_model
from eai.generator.generator import Generator
from eai.generator.spec import Spec
from eai.tasks.source import Source
from generator.worlds import HOUSEHOLDS, tasks

pytestmark = pytest.mark.usefixtures("data_store")


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_generated_tasks_say_how_difficult_they_are_expected_to_be(like: str) -> None:
    model = difficulty_model(like)
    assert model is not None
    for made in tasks(like, 12):
        task = made.task
        log_steps, log_goals = math.log(len(task.script)), math.log(1 + len(task.goals))
        operators = len({action.operator for action in task.script})
        steps, kinds, goals = model.weights
        value = model.intercept + steps * log_steps + kinds * operators + goals * log_goals
        assert made.about["difficulty"] == {"expected": round(value, 2), "error": model.error}


def test_longer_plans_and_more_goals_are_harder() -> None:
    model = DifficultyModel(-2.0, (1.0, 0.1, 0.5), 1.4, 0.4, 0.6)
    task = tasks("virtualhome", 12)[0].task
    found = model.expected(task)
    longer = model.expected(replace(task, script=task.script * 2))
    assert found is not None
    assert longer is not None
    assert longer.value == pytest.approx(found.value + math.log(2), abs=0.011)
    assert model.expected(replace(task, script=())) is None


@pytest.mark.parametrize("like", HOUSEHOLDS)
def test_the_coefficients_are_those_of_the_public_tasks(like: str) -> None:
    pytest.importorskip("scipy")
    path = Path(__file__).parents[2] / "tools" / "task_difficulty.py"
    spec = spec_from_file_location("task_difficulty", path)
    assert spec is not None
    assert spec.loader is not None
    tool = module_from_spec(spec)
    spec.loader.exec_module(tool)
    known = json.loads((resources.files("eai.generator") / FILE).read_text(encoding="utf-8"))[like]
    fitted = tool.fitted(like)
    assert fitted["weights"] == pytest.approx(known["weights"], abs=0.002)
    assert {**fitted, "weights": 0} == pytest.approx({**known, "weights": 0}, abs=0.011)


def test_of_a_world_that_nobody_was_asked_about_nothing_is_said() -> None:
    assert difficulty_model("lamps") is None
    benchmark, source = replace(find_benchmark("behavior"), name="another"), Source()
    with pytest.raises(InputError, match="is not known"):
        Generator(benchmark, Spec("behavior", "", difficulty=(0.0, 1.0)), source)
