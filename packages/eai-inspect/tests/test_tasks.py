"""Tests that Inspect's register accepts the package and that its tasks run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from inspect_ai import eval as run

import eai_inspect
from eai.run.registry import TASKS

PACKAGE = Path(__file__).parents[1]


def test_the_linter_of_the_register_finds_nothing() -> None:
    command = [sys.executable, "-m", "inspect_evals_lint", "--preset", "single-eval", "eai_inspect"]
    done = subprocess.run(command, cwd=PACKAGE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert "FAIL" not in done.stdout


def test_what_is_declared_is_there() -> None:
    declared = yaml.safe_load((PACKAGE / "src/eai_inspect/eval.yaml").read_text(encoding="utf-8"))
    assert sorted(task["name"] for task in declared["tasks"]) == sorted(eai_inspect.__all__)


@pytest.mark.parametrize("name", eai_inspect.__all__)
def test_a_task_is_that_of_the_core(name: str) -> None:
    of_core = TASKS[name]().dataset
    ours = getattr(eai_inspect, name)().dataset
    assert [sample.id for sample in ours] == [sample.id for sample in of_core]


def test_an_answer_is_scored(tmp_path: Path) -> None:
    """The model is built in, because mockllm/model counts tokens with a file that Inspect downloads."""
    task = eai_inspect.virtualhome_action_sequencing(tasks="27_2")
    (log,) = run(task, model="eai/oracle", display="none", log_dir=str(tmp_path))
    assert log.status == "success"
    assert log.samples is not None
    (score,) = (log.samples[0].scores or {}).values()
    assert score.value == "C"
