"""``eai play``: a person's episodes are answers as others; what counts, what resumes, and what is refused."""

from __future__ import annotations

import io
import json
import os
import pty
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from select import select
from typing import TypeAlias

import pytest

from agents.switches import SWITCHES, WON, initial
from by_path import TESTS
from command_line import Command, Outcome
from eai import make_task
from eai.agents.play import EpisodeFactory, read_commands
from eai.agents.setting import ACTING
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import open_suite
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark, SpecialTaskMark
from eai.tasks.task_lines import write_task_line

DOMAIN = "agents.switches:SWITCHES"
Playing: TypeAlias = Callable[..., Outcome]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "ann_outputs.json"


@pytest.fixture
def play(eai: Command, monkeypatch: pytest.MonkeyPatch, out: Path) -> Playing:
    """Plays tasks with these lines as standard input."""

    def run(*lines: str, tasks: str = "both", domain: str = DOMAIN, more: tuple[str, ...] = ()) -> Outcome:
        monkeypatch.setattr(sys, "stdin", io.StringIO("".join(f"{line}\n" for line in lines)))
        return eai("play", "--domain", domain, "--tasks", tasks, "--out", out, *more)

    return run


def said(out: Path) -> list[str]:
    """The commands in a file of one answer."""
    (row,) = json.loads(out.read_bytes())
    return [turn["said"] for turn in json.loads(row["llm_output"])["turns"]]


def harness(out: Path) -> str:
    return str(json.loads(json.loads(out.read_bytes())[0]["llm_output"])["harness"])


@pytest.mark.parametrize(("domain", "task"), [("virtualhome", "27_2"), ("behavior", None), (DOMAIN, "both")])
def test_an_episode_is_scored_as_that_of_a_model_that_does_the_same(
    domain: str, task: str | None, play: Playing, eai: Command, out: Path, tmp_path: Path
) -> None:
    suite = open_suite(find_benchmark(domain), ACTING)
    task = task or suite.task_ids[0]
    commands = EpisodeFactory(suite.benchmark).play_episode_and_return_commands(
        "oracle", suite.tasks[task], 0, 1
    )
    done = play(*commands, tasks=task, domain=domain)
    assert (done.status, done.err) == (0, "")
    assert f"1 of 1 task over; written to {out}" in done.out
    options = ("--domain", domain, "--ability", "acting", "--allow-missing", "--out", tmp_path / "scores")
    assert eai("score", out, *options).status == 0
    records = (tmp_path / "scores" / "records.jsonl").read_text("utf-8").splitlines()
    (record,) = [each for each in map(json.loads, records) if each["task_id"] == task]
    assert (record["success"], record["harness"], record["model"]) == (True, "person", "ann")
    assert [turn["said"] for turn in record["turns"]] == commands


@pytest.mark.parametrize(
    ("special", "line", "command"),
    [
        (PossiblyImpossibleTaskMark(()), "impossible dark", "IMPOSSIBLE(dark)"),
        (AmbiguousTaskMark(("lamp",)), "ask which", "ASK(which)"),
    ],
)
def test_a_person_may_write_commands_without_a_plan_in_small_letters(
    special: SpecialTaskMark, line: str, command: str, play: Playing, out: Path, tmp_path: Path
) -> None:
    task = make_task("t", "Light the lamp.", initial(), "lit(lamp)", domain=SWITCHES.domain)
    file = tmp_path / "tasks.jsonl"
    file.write_text(write_task_line(replace(task, special=special), DOMAIN, SWITCHES.domain))
    assert play(line, tasks="t", domain=str(file)).status == 0
    assert said(out) == [command]


def test_no_file_is_named_as_written_if_nobody_played(play: Playing, out: Path) -> None:
    done = play()
    assert done.status == 0
    assert not out.exists()
    assert f"0 of 1 task over; no command was given, so {out} is not written" in done.out
    assert "eai score" not in done.out


def test_lines_that_count_and_lines_that_do_not(play: Playing, out: Path) -> None:
    lines = ("go shed", "go( hall )", "look", "look", "pres lamp", "Press(lamb)", "[WAVE")
    told = play("", "help", " ", *lines).out
    commands = ["GO(shed)", "GO( hall )", "LOOK", "LOOK", "pres(lamp)", "PRESS(lamb)", "[WAVE"]
    assert (said(out), harness(out)) == (commands, "person")
    assert "\nPRESS(x)\n" in told
    assert "pres is not an action.\n10 of 14 actions left.\n(did you mean PRESS?)" in told
    assert "PRESS: you have not yet seen lamb.\n9 of 14 actions left.\n(did you mean lamp?)" in told
    assert "Failed (parsing): no action was found. Write one action, such as GO(x).\n8 of 14" in told


def test_what_is_possible_is_told_to_who_asks_and_the_record_says_so(play: Playing, out: Path) -> None:
    told = play("? SHED", "?", "? torch").out
    assert "> ? SHED\nGO: shed\n" in told
    assert "> ?\nGO: shed\nOPEN: robot lamp\nPRESS: lamp\nWAVE\n" in told
    assert "> ? torch\nNothing like that." in told
    assert (said(out), harness(out)) == ([], "person who asked what is possible")
    play(*WON, "DONE")
    assert harness(out) == "person who asked what is possible"


def test_the_same_command_resumes_within_a_task_and_after_it(play: Playing, out: Path) -> None:
    first = play(WON[0], "quit", WON[1])
    assert "0 of 2 tasks over" in play(tasks="both,half").out
    assert (first.status, said(out)) == (0, [WON[0]])
    second = play(*WON[1:], "DONE", "done", tasks="both,half")
    assert "> PRESS(lamp)\nPRESS(lamp): done.\n" in second.out
    assert "Task 2 of 2" in second.out
    assert "2 of 2 tasks over" in second.out
    episodes = [row["llm_output"] for row in json.loads(out.read_bytes())]
    suite = open_suite(DOMAIN, ACTING)
    assert read_commands(suite.tasks["both"], suite.benchmark, episodes[0]) == [*WON, "DONE"]
    assert "Task" not in play(tasks="both").out


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        ("DONE", "both: the file --out has an episode that cannot be resumed: a model played it, or it had"),
        ('{"turns": 3}', "both: the answer in the file --out cannot be read as an episode: turns: expected"),
        ('{"turns": [{"said": "GO(shed)", "told": "0"}]}', "both: the file --out has an episode that cannot"),
    ],
)
def test_an_answer_that_is_no_episode_of_a_person_is_not_played_on(
    answer: str, why: str, play: Playing, out: Path
) -> None:
    out.write_text(json.dumps([{"identifier": "both", "llm_output": answer}]))
    before = out.read_bytes()
    done = play("DONE")
    assert (done.status, out.read_bytes()) == (2, before)
    assert why in done.err


def test_another_setting_is_another_episode(play: Playing, out: Path) -> None:
    options = ("--with", "observe=full", "--with", "agent.feedback=facts")
    assert play(WON[0], more=options).status == 0
    assert "it had other settings" in play(WON[1]).err
    assert play(WON[1], more=options).status == 0
    assert said(out) == [*WON[:2]]


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (("--with", "tokens=3"), "--with tokens: this option is only for models"),
        (
            ("--with", "feedback=pictures"),
            "--with feedback=pictures: a terminal shows no pictures; add --page PORT",
        ),
        (("--with", "view"), "--with view: expected OPTION=VALUE"),
        (("--with", "veiw=full"), "agent.veiw: unknown; did you mean view?"),
        (("--out", "ann.json"), "expected a name that ends with _outputs.json"),
        (("--tasks", "bth"), "--tasks: 'bth' is not a task of switches acting; did you mean both?"),
        (("--tasks", "none"), "none cannot be played"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(more: tuple[str, ...], why: str, play: Playing) -> None:
    done = play("DONE", more=more)
    assert done.status == 2
    assert why in done.err
    assert done.err.count("\n") == 1


def test_two_at_once_do_not_overwrite_each_other(
    eai: Command, monkeypatch: pytest.MonkeyPatch, out: Path
) -> None:
    class Busy(io.StringIO):
        def readline(self, *_: object) -> str:
            out.write_text("[]")
            return "WAVE\n"

    monkeypatch.setattr(sys, "stdin", Busy())
    done = eai("play", "--domain", DOMAIN, "--out", out)
    assert (done.status, out.read_text()) == (2, "[]")
    assert "another program has written this file" in done.err


def test_on_a_terminal_words_are_completed_and_an_interrupt_loses_nothing(out: Path) -> None:
    """The tabulator completes an action, and an object that has been seen."""
    pytest.importorskip("readline", reason="no readline on this machine")
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "eai", "play", "--domain", DOMAIN, "--tasks", "both", "--out", str(out)]
    environment = {**os.environ, "PYTHONPATH": f"{TESTS.parent / 'src'}:{TESTS}", "TERM": "dumb"}
    with subprocess.Popen(command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment) as process:

        def read(until: str) -> str:
            got = b""
            while until.encode() not in got:
                if not select([ours], [], [], 60)[0]:
                    process.kill()
                    pytest.fail(f"nothing after {got!r}")
                got += os.read(ours, 4096)
            return got.decode().replace("\r\n", "\n")

        opening = read("> ")
        assert max(map(len, opening.splitlines())) <= 80
        os.write(ours, b"pr\t l\t\n")
        assert "PRESS(lamp): done." in read("13 of 14 actions left.\r\n\r\n> ")
        process.send_signal(signal.SIGINT)
        os.write(ours, b"\n")  # or Python does not see a signal that comes while it begins to wait
        assert "interrupted; the same command resumes" in read("from here")
        assert process.wait(60) == 130
    assert said(out) == ["PRESS(lamp)"]
