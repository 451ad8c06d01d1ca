"""Runs that choose tasks by how difficult they are."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.test_run import NAMED, SUITE
from eai.base.store import DataPackStore
from eai.extensions.adaptive.short_tests import short_test
from processes import eai
from protocols import PROTOCOLS
from sweeps import sweep


@sweep
def test_an_adaptive_run_ends_at_the_target_error_and_resumes_after_an_interruption(
    data_store: DataPackStore, tmp_path: Path
) -> None:
    named = ("--domain", "behavior", "--ability", "action_sequencing", "--adaptive", 0.5, "--out", tmp_path)
    noisy = ("run", "--model", "eai/noisy", "-M", "rate=0.1", *named)
    first = eai(*noisy)
    assert first.status == 0, first.err
    folder = tmp_path / "behavior/action_sequencing/eai_noisy"
    journal, records = folder / "answers.jsonl", folder / "records.jsonl"
    found = json.loads((folder / "adaptive.json").read_text())
    asked = len(found["tasks"])
    assert 10 <= asked == len(set(found["tasks"])) <= 30
    assert asked % 5 == 0
    assert found["error"] <= found["target"] == 0.5
    told = f"ability {found['ability']:+.2f} logits, standard error {found['error']:.2f}, from {asked} of"
    assert told in " ".join(first.out.split())
    assert "the run is not ranked" in first.err
    lines, bytes_before = journal.read_text().splitlines(), records.read_bytes()
    journal.write_text("".join(f"{line}\n" for line in lines[:7]))
    again = eai(*noisy)
    assert again.status == 0, again.err
    assert sorted(journal.read_text().splitlines()) == sorted(lines)
    assert json.loads((folder / "adaptive.json").read_text()) == found
    assert records.read_bytes() == bytes_before


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--ability", "goal_interpretation"), "the tasks of behavior goal_interpretation have no known"),
        *(
            (("--protocol", protocol), "difficulties are only known under the protocol strict")
            for protocol in PROTOCOLS[1:]
        ),
        (
            ("--with", "replanning.replans=2"),
            "cannot be combined with replanning.replans, slip or until; ",
        ),
    ],
)
def test_an_adaptive_run_refuses_suites_without_difficulties(
    tmp_path: Path, options: tuple[object, ...], message: str
) -> None:
    named = ("--domain", "behavior", "--adaptive", 0.3, "--out", tmp_path)
    run = eai("run", "--model", "eai/oracle", *named, *options)
    assert run.status == 2
    assert f"adaptive: {message}" in " ".join(run.err.split())


def test_the_short_test_of_a_suite_is_run_by_its_name(data_store: DataPackStore, tmp_path: Path) -> None:
    named = (*NAMED, "--tasks", "short", "--limit", 3, "--json", "--out", tmp_path)
    run = eai("run", "--model", "eai/oracle", *named)
    assert run.status == 0, run.err
    lines = (tmp_path / "virtualhome/action_sequencing/eai_oracle/records.jsonl").read_text().splitlines()
    asked = [json.loads(line)["task_id"] for line in lines]
    assert asked == list(short_test(*SUITE)[:3])
