"""The journal under faults of disk, folder and clock: no answer counts as stored that is not."""

from __future__ import annotations

import re
import resource
import shutil
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import eai
from eai.abilities.attempt import AnswerUsage
from eai.base.errors import InputError
from eai.base.files import lock_run_folder
from eai.run.journal import Answer, AnswerJournal
from sweeps import sweep

ANSWER = Answer("27_2", 1, "request", "prompt", "{}", "", "stop", (), AnswerUsage(3, 5))

HOLDER = """
import sys
from pathlib import Path
from eai.base.files import lock_run_folder
with lock_run_folder(Path(sys.argv[1])):
    print("there", flush=True)
    sys.stdin.read()
"""


def test_two_processes_cannot_run_in_one_folder(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, folder], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "there\n"
        with (
            pytest.raises(InputError, match=r"run: another process is writing to this folder"),
            lock_run_folder(folder),
        ):
            pass
        with lock_run_folder(tmp_path / "another"):
            pass
        holder.kill()  # however it ends
        holder.wait()
        with lock_run_folder(folder):
            pass
    with lock_run_folder(folder):
        journal = AnswerJournal(folder / "answers.jsonl")
        journal.write_answer(ANSWER)


def test_a_full_disk_in_the_middle_of_an_answer_loses_only_that_answer(tmp_path: Path) -> None:
    file = tmp_path / "answers.jsonl"
    journal = AnswerJournal(file)
    journal.write_answer(ANSWER)
    size, limits = file.stat().st_size, resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + size // 2, limits[1]))
    try:
        full = AnswerJournal(file)
        with pytest.raises(InputError, match=r"answers\.jsonl: cannot be written \(File too large\)"):
            full.write_answer(replace(ANSWER, epoch=2))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)
    assert full.find_answer(("27_2", 2), "request") is None
    full.write_answer(replace(ANSWER, epoch=3))  # an answer to a concurrent request
    assert AnswerJournal(file).find_answer(("27_2", 3), "request") == replace(ANSWER, epoch=3)
    mended = AnswerJournal(file)
    assert mended.find_answer(("27_2", 1), "request") == ANSWER
    assert mended.find_answer(("27_2", 2), "request") is None
    mended.write_answer(replace(ANSWER, epoch=2))
    assert AnswerJournal(file).find_answer(("27_2", 2), "request") == replace(ANSWER, epoch=2)


def test_a_folder_removed_during_a_run_is_an_error(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    journal = AnswerJournal(folder / "answers.jsonl")
    journal.write_answer(ANSWER)
    shutil.rmtree(folder)
    with pytest.raises(InputError, match=r"answers\.jsonl: cannot be written \(No such file or directory\)"):
        journal.write_answer(replace(ANSWER, epoch=2))


def test_an_unwritable_folder_is_reported_before_any_question(tmp_path: Path) -> None:
    """A file in the way stands for a folder without permission, which would not stop root."""
    (tmp_path / "run").write_text("")
    with pytest.raises(InputError, match=r"run: cannot be written"), lock_run_folder(tmp_path / "run"):
        pass
    with pytest.raises(InputError, match=r"answers\.jsonl: cannot be written"):
        AnswerJournal(tmp_path / "run" / "answers.jsonl").write_answer(ANSWER)


def test_a_clock_that_jumps_changes_no_answer() -> None:
    """Durations are measured by the monotonic clock, which cannot be set."""
    time_of_day = re.compile(
        r"\btime\.(time|ctime|localtime|gmtime)\b|\bdatetime\.(now|utcnow|today)\b|\bdate\.today\b"
    )
    modules = sorted(Path(eai.__file__).parent.rglob("*.py"))
    assert len(modules) > 100
    assert [path for path in modules if time_of_day.search(path.read_text(encoding="utf-8"))] == []


@sweep
def test_a_journal_of_a_hundred_thousand_answers_is_read_quickly(tmp_path: Path) -> None:
    file, number = tmp_path / "answers.jsonl", 100_000
    journal = AnswerJournal(file)
    for epoch in range(1, number + 1):
        journal.write_answer(replace(ANSWER, epoch=epoch))
    again = AnswerJournal(file)
    assert all(again.find_answer(("27_2", epoch), "request") for epoch in (1, number // 2, number))
    assert len(file.read_bytes().splitlines()) == number
