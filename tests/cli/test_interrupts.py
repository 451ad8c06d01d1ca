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

from eai.abilities.protocol import Ability
from eai.base.store import Store
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
    data_store: Store,
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
            assert errors.splitlines()[-1] == "eai: interrupted; nothing is written"
            assert list(scratch.iterdir()) == []
    finally:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_is_interrupted_while_the_built_in_planner_searches(
    data_store: Store, tmp_path: Path, number: signal.Signals
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
    data_store: Store, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, number: signal.Signals
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
