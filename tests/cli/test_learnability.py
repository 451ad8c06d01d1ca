"""`eai check --learnable` prints rewards of null models, mixed groups of answers, and too long questions."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import eai as library
from by_path import ROOT
from command_line import Command
from eai.benchmarks.gold_answers import open_gold_answers
from eai.results.batch import Scoring

LAMPS = ("check", "lamps:lamps", "--learnable")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples" / "lamps")
    monkeypatch.chdir(tmp_path)


def score(eai: Command, name: str, *answers: str) -> None:
    """Score answers to the first task as samples."""
    task_id = library.open("lamps:lamps", "action_sequencing").task_ids[0]
    rows = [
        {"identifier": task_id, "llm_output": text, "sample": number} for number, text in enumerate(answers)
    ]
    Path(f"{name}_outputs.json").write_text(json.dumps(rows))
    asked = ("--domain", "lamps:lamps", "--ability", "action_sequencing", "--out", Path("scores") / name)
    done = eai("score", f"{name}_outputs.json", *asked, "--allow-missing")
    assert done.status == 0, done.err


def test_null_models_have_a_row_each(eai: Command) -> None:
    done = eai(*LAMPS)
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("lamps action_sequencing: null models' reward progress, percent\n")
    assert [line.split()[0] for line in done.out.splitlines() if line.startswith("eai/")] == [
        *("eai/copy", "eai/empty", "eai/lookup", "eai/random")
    ]


def test_groups_of_answers_with_mixed_rewards_are_counted(eai: Command) -> None:
    suite = library.open("lamps:lamps", "action_sequencing")
    right = open_gold_answers(suite.benchmark, suite.ability)[suite.task_ids[0]].text
    score(eai, "mixed", right, "no plan")
    score(eai, "equal", "no plan", "no idea")
    done = eai(*LAMPS, "--records", "scores")
    assert done.out.endswith(
        "mixed rewards in 1 of 2 groups of answers (50.0 %); equal rewards: 1 with no reward\n"
    )
    score(eai, "single", right)
    done = eai(*LAMPS, "--records", "scores/single")
    assert done.out.endswith("no task has two answers of one model: run the model with --epochs\n")


def test_workers_compute_the_same_rewards(eai: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    score(eai, "single", "no plan")
    alone = eai(*LAMPS, "--records", "scores")
    compute, numbers = Scoring.compute_rewards, []

    def compute_and_count(scoring: Scoring, *arguments: Any) -> Iterator[float | None]:
        numbers.append(scoring.has_worker_processes)
        return compute(scoring, *arguments)

    monkeypatch.setattr(Scoring, "compute_rewards", compute_and_count)
    done = eai(*LAMPS, "--records", "scores", "--workers", 2)
    assert (done.status, done.out) == (0, alone.out)
    assert numbers == [True] * 5


def test_tasks_that_exceed_a_context_are_counted(eai: Command) -> None:
    done = eai(*LAMPS, "--context", 100)
    assert "tasks of lamps action_sequencing need more than 100 tokens (" in done.out
    assert done.out.endswith(", by estimate (--set official)\n")
    assert eai(*LAMPS, "--context", 100_000).out.endswith(
        "all 2 tasks fit into 100,000 tokens, by estimate (--set official)\n"
    )
    value = json.loads(eai(*LAMPS, "--context", 100, "--json").out)
    assert value["too_long"] == [*library.open("lamps:lamps", "action_sequencing").task_ids]
    assert value["null_models"]["eai/empty"]["full"]["numerator"] == 0


def test_an_ability_without_rewards_is_refused(eai: Command) -> None:
    refused = eai(*LAMPS, "--ability", "acting")
    assert (refused.status, refused.out) == (2, "")
    assert eai("check", "--learnable").err.startswith("eai: expected a benchmark: ")
