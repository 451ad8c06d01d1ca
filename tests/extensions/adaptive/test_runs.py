from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import rmtree
from typing import Any, cast

import pytest

from command_line import Command
from eai.abilities.protocol import Ability
from eai.abilities.verdict import PlanVerdict
from eai.agents.play import EpisodeFactory
from eai.agents.setting import ACTING
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.benchmarks.suite import Suite, open_suite
from eai.extensions.adaptive import runs as runs_module
from eai.extensions.adaptive.difficulties import load_task_difficulties
from eai.extensions.adaptive.runs import prepare_adaptive_runs
from eai.results.record import Record
from eai.tasks.source import Source
from results.verdicts import SUCCEEDED, record

SUITE = ("behavior", Ability.ACTION_SEQUENCING)


@dataclass
class Result:
    """As much of a run's result as is looked at."""

    folder: Path
    suite: Suite
    records: list[Record]
    task_ids_by_failure_reason: dict[str, list[str]]
    model: str = "m"


@pytest.mark.parametrize("excluded", [True, False])
def test_excluded_tasks_are_asked_once_and_do_not_change_the_ability(
    data_store: DataPackStore, tmp_path: Path, *, excluded: bool
) -> None:
    """An excluded task is left out of the estimate; an unanswerable task also ends the run."""
    suite = open_suite(*SUITE, source=Source(data_store))
    odd = min(known := load_task_difficulties(*SUITE), key=lambda task: (abs(known[task]), task))
    rounds: list[list[str]] = []

    def ask(prompts: Mapping[str, Any]) -> Any:
        rounds.append(list(prompts))
        records = [record(task, SUCCEEDED, domain=suite.domain) for task in prompts]
        changes = {"verdict": PlanVerdict(excluded="no solution")} if excluded else {"unanswered": "timeout"}
        records = [replace(each, **changes) if each.task_id == odd else each for each in records]
        return Result(tmp_path, suite, records, {} if excluded else {"timeout": [odd]})

    _, obtain = prepare_adaptive_runs([suite], (), None)
    obtain(ask, cast(Any, dict.fromkeys(suite.task_ids)), suite, 0.6)
    assert odd in rounds[0]
    sizes = [len(asked) for asked in rounds]
    assert sizes == [5 * number for number in range(1, len(rounds) + 1)]
    assert (len(rounds) == 1) == (not excluded)


@pytest.fixture
def runs(eai: Command, tmp_path: Path) -> Path:
    """Runs of models that act: one wins all tasks, one some and one none; one had two tasks; one is null."""
    suite = open_suite("agents.switches:SWITCHES", ACTING)
    for model, won in {"good": 4, "fair": 2, "poor": 0, "short": 1, "eai_empty": 0}.items():
        answers = [
            {"identifier": task_id, "llm_output": answer_of(suite, task_id) if place < won else "WAVE"}
            for place, task_id in enumerate(suite.task_ids)
        ]
        file = tmp_path / f"{model}_outputs.json"
        file.write_text(json.dumps(answers[:2] if model == "short" else answers))
        named = ("--domain", "agents.switches:SWITCHES", "--ability", "acting", "--allow-missing")
        assert eai("score", file, *named, "--out", tmp_path / "runs" / model).status == 0
    return tmp_path / "runs"


def answer_of(suite: Suite, task_id: str) -> str:
    """Commands that win a task; of one that is not played none do."""
    task = suite.tasks[task_id]
    commands = (
        EpisodeFactory(suite.benchmark).make_setup(task).reference.commands
        if task.unplannable_reason is None
        else None
    )
    return "\n".join([*(commands or ()), "DONE"])


def test_runs_of_several_models_tell_how_difficult_tasks_are(runs: Path, tmp_path: Path) -> None:
    suite = open_suite("agents.switches:SWITCHES", ACTING)
    assert prepare_adaptive_runs([suite], [ACTING], runs)[0] == [suite]
    known, _, models = runs_module._estimate_difficulties(suite, runs)
    assert models == f"the 3 models in {runs}"
    easy, hard = known["both"], known["half"]
    assert [*known] == [task_id for task_id in suite.task_ids if task_id != "none"]
    assert easy == known["greet"] < hard
    rmtree(runs / "fair")
    with pytest.raises(
        InputError,
        match="of at least 3 models with all answers to switches acting under strict; found 2 models",
    ):
        prepare_adaptive_runs([suite], [ACTING], runs)
    with pytest.raises(InputError, match="acting have no known difficulties; --with tasks"):
        prepare_adaptive_runs([suite], [ACTING], None)
