"""Questions from worker processes equal one process's, also if a worker is killed or the command is ended."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from itertools import islice
from pathlib import Path

import pytest

from command_line import Command
from eai.base.store import DataPackStore
from eai.benchmarks.benchmark import Benchmark
from eai.extensions.questions.question import QuestionForm, QuestionKind, questions_to_bytes
from eai.extensions.questions.writer import QuestionGenerator
from eai.results.workers import WorkerPool
from processes import wait_until

SECONDS_TO_END = 10
"""Maximum seconds from a signal to the end of the command: 2 on an idle machine."""


@pytest.mark.parametrize("settings", [["--n", 50], ["--n", 40, "--no-rules", "--form", "open"]])
@pytest.mark.usefixtures("lamps")
def test_any_number_of_workers_writes_the_same_bytes(
    eai: Command, tmp_path: Path, settings: list[object]
) -> None:
    files = [tmp_path / f"{workers}.jsonl" for workers in (1, 2)]
    for workers, file in enumerate(files, 1):
        fixed = ("--domain", "lamps:lamps", "--seed", 8, "--out", file, "--workers", workers)
        outcome = eai("export", "questions", *fixed, *settings)
        assert outcome.status == 0, outcome.err
    assert files[0].read_bytes() == files[1].read_bytes() != b""


def test_a_killed_worker_loses_and_repeats_no_question(lamps: Benchmark) -> None:
    number = 2 * len(QuestionKind) * len(QuestionForm) + 5  # the last five are written in a second round
    counts: list[int] = []
    with WorkerPool(2) as pool:
        questions = QuestionGenerator(lamps).write_questions(
            number=number, seed=1, pool=pool, report=counts.append
        )
        from_workers = list(islice(questions, 1))
        pool._workers[0].process.kill()
        from_workers += questions
    alone = list(QuestionGenerator(lamps).write_questions(number=number, seed=1))
    assert questions_to_bytes(from_workers) == questions_to_bytes(alone)
    assert counts == sorted(counts)
    assert counts[-1] == len(alone)


def test_questions_of_a_kind_do_not_depend_on_other_kinds(lamps: Benchmark) -> None:
    kind, form = QuestionKind.STATE, QuestionForm.CHOICE
    together = QuestionGenerator(lamps).write_questions(number=108)
    alone = QuestionGenerator(lamps).write_questions([kind], [form], 3)
    assert [each for each in together if (each.kind, each.form) == (kind, form)] == list(alone)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_workers_that_write_questions_end_quickly(
    data_store: DataPackStore,
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    number: signal.Signals,
) -> None:
    scratch = tmp_path_factory.mktemp("s")  # a short path, because sockets lie in it
    out, errors = tmp_path / "questions.jsonl", tmp_path / "errors"
    command = [sys.executable, "-c", "from eai.cli import main; main()", "export", "questions"]
    with errors.open("w") as file:
        process = subprocess.Popen(
            [*command, "--domain", "behavior", "--n", "100000", "--workers", "2", "--out", str(out)],
            env={**os.environ, "TMPDIR": str(scratch)},
            stderr=file,
            start_new_session=True,
        )
    try:
        assert wait_until(lambda: re.search(r"writing questions on behavior: [1-9]", errors.read_text()))
        begun = time.monotonic()
        os.killpg(process.pid, number) if number is signal.SIGINT else process.send_signal(number)
        assert process.wait(600) == 128 + number
        assert time.monotonic() - begun < SECONDS_TO_END
    finally:
        process.kill()
    assert [*scratch.iterdir(), *tmp_path.glob("*.jsonl")] == []
