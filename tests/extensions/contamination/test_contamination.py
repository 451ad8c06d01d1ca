"""Public beside fresh tasks: a row a model, paired by the names of suites."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from eai.abilities.protocol import Ability, Protocol
from eai.abilities.task_features import TaskFeatures
from eai.abilities.verdict import PlanVerdict
from eai.cli import app
from eai.extensions.contamination.study import _pair_public_with_fresh_runs, make_contamination_table
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.results.table import Estimate
from eai.tasks.share import Share, TalliesByGoalKind
from record_files import write_records
from studies.told import told_tables


def record(domain: str, number: int, steps: int, right: bool, excluded: str | None = None) -> Record:
    goals = TalliesByGoalKind(Share(int(right), 1), Share(0, 0), Share(0, 0))
    verdict = PlanVerdict(excluded=excluded, executable=True, success=right, goals=goals)
    task = TaskFeatures(f"name {number}", steps, 1)
    ability = Ability.ACTION_SEQUENCING
    return Record(Protocol.STRICT, domain, ability, "m", f"{number}", "", "0", verdict, task=task)


PUBLIC = [
    *(record("world", i, 3, i < 8) for i in range(10)),
    *(record("world", i, 30, False) for i in range(10, 20)),
    record("world", 20, 3, False, "it has no goals"),
]
FRESH = [record("world-fresh", i, 4, i < 5) for i in range(20)]


def test_only_alike_tasks_are_set_beside_each_other() -> None:
    (row,) = make_contamination_table([("m", "world", PUBLIC, FRESH)]).rows
    _, _, public, _, public_alike, fresh_alike, difference, *tasks = row
    assert (public.value, public_alike, fresh_alike) == (40.0, 80.0, 25.0)  # type: ignore[union-attr]
    assert tasks == [10, 20]
    assert isinstance(difference, Estimate)
    assert difference.value == -55.0
    assert difference.high is not None
    assert difference.high < 0


def test_runs_are_paired_by_the_world(tmp_path: Path) -> None:
    for name, records in (("a", PUBLIC), ("b", FRESH)):
        folder = tmp_path / "runs" / name
        folder.mkdir(parents=True)
        write_records(folder / "records.jsonl", records)
    out = tmp_path / "out"
    command = ["analyze", "contamination", str(tmp_path / "runs"), "--out", str(out), "--json"]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    (row,) = told_tables(done.stdout)["contamination"]
    assert float(row["difference"]) == -55
    written = json.loads((out / "contamination.json").read_text())
    assert "does not prove that the model knows no answers" in str(written)
    assert "-55 [" in (out / "contamination.md").read_text()


@pytest.mark.parametrize(
    ("public", "fresh", "is_pair"),
    [
        ("behavior", "behavior-fresh", True),
        ("behavior", "behavior-1k", False),  # another public benchmark
        ("behavior", "behavior-1k-fresh", False),
        ("behavior-1k", "behavior-1k-fresh", True),
        ("world", "world-obfuscated", False),  # the same tasks in other words
        ("world", "world-fresh-rules", False),
        ("world-rules", "world-fresh-rules", True),
        ("world-obfuscated", "world-fresh-obfuscated", True),
    ],
)
def test_fresh_tasks_are_of_the_same_world_with_equal_prompts(public: str, fresh: str, is_pair: bool) -> None:
    ability = Ability.ACTION_SEQUENCING
    runs = [Run(RunKey(Protocol.STRICT, name, ability, "m"), ()) for name in (public, fresh)]
    pairs = [suite for _, suite, *_ in _pair_public_with_fresh_runs(runs)]
    assert pairs == [f"{fresh} action_sequencing"] * is_pair


def test_without_a_pair_there_is_nothing_to_say(tmp_path: Path) -> None:
    write_records(tmp_path / "records.jsonl", PUBLIC)
    done = CliRunner().invoke(app, ["analyze", "contamination", str(tmp_path), "--out", str(tmp_path)])
    assert done.exit_code != 0
