"""Commands that are interrupted, asked to end or killed: no process and no temporary folder stays."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from counted_planner import CountedPlanner
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from eai.pddl.fast_downward import FastDownward
from processes import Command, wait_until, working_in
from run.hindrances import search_forever
from suites import answer_book

SUITE = ("behavior", Ability.TRANSITION_MODELING)

_SECONDS_TO_END = 10
"""Maximum seconds from a signal to the end of a command: 2 on an idle machine."""


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.skipif(not FastDownward.is_installed(), reason="Fast Downward is not installed")
@pytest.mark.parametrize("workers", [1, 3])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_nothing_outlives_scoring_that_ends_early(
    data_store: DataPackStore,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    number: signal.Signals,
    workers: int,
) -> None:
    book = answer_book(*SUITE, data_store)
    scratch = tmp_path_factory.mktemp("s")  # sockets lie in it, whose paths are of 107 characters at most
    rows = [{"identifier": task_id, "llm_output": book[task_id].text} for task_id in book]
    (tmp_path / "gold_outputs.json").write_text(json.dumps(rows))
    arguments = f"score {tmp_path}/gold_outputs.json --domain {SUITE[0]} --ability {SUITE[1].value}"
    arguments += f" --planner fast_downward --workers {workers}"
    process = subprocess.Popen(
        [sys.executable, "-c", "from eai.cli import main; main()", *arguments.split()],
        env={**os.environ, "TMPDIR": str(scratch)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert wait_until(lambda: working_in(scratch)), "no planner ever started"
        os.killpg(process.pid, number) if number is signal.SIGINT else process.send_signal(number)
        printed, errors = process.communicate(timeout=600)
        assert wait_until(lambda: not working_in(scratch)), "a planner is still alive"
        if number is not signal.SIGKILL:
            assert (process.returncode, printed) == (128 + number, "")
            assert errors.splitlines()[-1] == (
                "eai: interrupted; nothing is written, because --out is not given"
            )
            assert list(scratch.iterdir()) == []
    finally:
        process.kill()
        process.communicate()


def contents(folder: Path) -> dict[str, bytes]:
    """Return the contents of the files in a folder, without locks."""
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and not file.name.endswith(".lock")
    }


@pytest.mark.parametrize(
    ("number", "workers", "shards"),
    [(signal.SIGINT, 1, 1), (signal.SIGTERM, 1, 2), (signal.SIGKILL, 2, 1)],
)
def test_scoring_goes_on_after_an_interrupt_to_the_same_files(
    data_store: DataPackStore,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    number: signal.Signals,
    workers: int,
    shards: int,
) -> None:
    counted = CountedPlanner(tmp_path / "planner", monkeypatch)
    book = answer_book(*SUITE, data_store)
    answers, task_ids = tmp_path / "answers", [*book]
    answers.mkdir()
    for model, ids in (("first", task_ids[:2]), ("second", task_ids[2:10])):
        rows = [{"identifier": task_id, "llm_output": book[task_id].text} for task_id in ids]
        (answers / f"{model}_outputs.json").write_text(json.dumps(rows))
    arguments = f"score {answers} --domain {SUITE[0]} --ability {SUITE[1].value} --planner fast_downward"
    arguments += f" --workers {workers}" + (f" --shard 1/{shards}" if shards > 1 else "")
    command = [sys.executable, "-c", "from eai.cli import main; main()", *arguments.split(), "--out"]
    scratch = tmp_path_factory.mktemp("s")  # a killed command leaves its temporary files there
    environment = {**os.environ, "PYTHONPATH": str(counted.folder), "TMPDIR": str(scratch)}

    def score(out: str) -> subprocess.CompletedProcess[str]:
        options = {"env": environment, "capture_output": True, "text": True, "check": True}
        return subprocess.run([*command, str(tmp_path / out)], **options)  # type: ignore[call-overload, no-any-return]

    score("whole")
    assert counted.calls == 10 // shards
    counted.limit_calls(6 // shards)
    process = subprocess.Popen(
        [*command, str(tmp_path / "ended")], env=environment, stderr=subprocess.PIPE, text=True
    )
    try:
        assert wait_until(lambda: counted.is_waiting)
        process.send_signal(number)
        _, errors = process.communicate(timeout=600)
    finally:
        process.kill()
    counted.limit_calls(None)
    again = score("ended")
    if workers == 1:
        assert errors.splitlines()[-1] == (
            f"eai: interrupted; {106 // shards} of {200 // shards} answers are scored; "
            "the same command resumes from here"
        )
        assert again.stderr.startswith(f"{106 // shards} of {200 // shards} answers are kept")
        assert counted.calls == 4 // shards
    else:
        assert counted.calls <= 8
    assert contents(tmp_path / "ended") == contents(tmp_path / "whole")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_is_interrupted_while_the_built_in_planner_searches(
    data_store: DataPackStore, tmp_path: Path, number: signal.Signals
) -> None:
    arguments = (
        "run --model eai/planner --domain virtualhome --ability action_sequencing --tasks 27_2 --quiet"
    )
    run = Command(*arguments.split(), "--out", tmp_path, before=search_forever)
    try:
        assert wait_until(lambda: run.out == "searching\n")
        run.signal(number)
        done = run.outcome()
        assert done.err.splitlines()[-1] == "eai: interrupted; the same command resumes from here"
        assert done.status == 128 + number
    finally:
        run.end()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_workers_that_generate_end_quickly_and_their_tasks_are_written(
    data_store: DataPackStore,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    number: signal.Signals,
) -> None:
    scratch = tmp_path_factory.mktemp("s")  # a short path, because sockets lie in it
    folders, errors = [tmp_path / name for name in ("ended", "again")], tmp_path / "errors"
    command = [sys.executable, "-c", "from eai.cli import main; main()", "generate", "--like", "behavior"]
    with errors.open("w") as file:
        process = subprocess.Popen(
            [*command, "--n", "100000", "--workers", "2", "--out", str(folders[0])],
            env={**os.environ, "TMPDIR": str(scratch)},
            stderr=file,
            start_new_session=True,
        )
    try:
        assert wait_until(lambda: re.search(r"generating behavior: [1-9]", errors.read_text()))
        begun = time.monotonic()
        os.killpg(process.pid, number) if number is signal.SIGINT else process.send_signal(number)
        assert process.wait(600) == 128 + number
        assert time.monotonic() - begun < _SECONDS_TO_END
    finally:
        process.kill()
    assert list(scratch.iterdir()) == []
    written = re.search(r"eai: interrupted; (\d+) tasks? written to", errors.read_text())
    assert written is not None, errors.read_text()
    subprocess.run([*command, "--n", written[1], "--out", str(folders[1])], check=True, capture_output=True)
    for name in ("tasks.jsonl", "generated.json"):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes()
