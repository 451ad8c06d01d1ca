from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from cli.conftest import Command
from processes import eai as in_own_process
from processes import wait_until
from sweeps import swept

LAMPS = Path(__file__).parents[2] / "examples" / "lamps"


@pytest.fixture
def written(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two questions of each kind and form about the example world."""
    monkeypatch.chdir(LAMPS)
    file = tmp_path / "questions.jsonl"
    outcome = eai("questions", "--domain", "lamps:lamps", "--n", 72, "--out", file)
    assert outcome.status == 0, outcome.err
    assert "72 questions written to" in outcome.out
    return file


def test_options_alone_write(eai: Command, written: Path, tmp_path: Path) -> None:
    again = tmp_path / "again" / "questions.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 72, "--seed", 0, "--out", again)
    assert eai("questions", "write", *arguments).status == 0
    assert again.read_bytes() == written.read_bytes()


def test_no_order_of_a_set_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(LAMPS)
    written = set()
    for seed in "123":
        file = tmp_path / f"{seed}.jsonl"
        arguments = ("--domain", "lamps:lamps", "--n", 72, "--out", file)
        outcome = in_own_process("questions", *arguments, PYTHONHASHSEED=seed)
        assert outcome.status == 0, outcome.err
        written.add(file.read_bytes())
    assert len(written) == 1


def test_kinds_and_forms_can_be_chosen(eai: Command, written: Path, tmp_path: Path) -> None:
    file = tmp_path / "some.jsonl"
    chosen = ("--kind", "forward", "--kind", "state", "--form", "open")
    assert eai("questions", "--domain", "lamps:lamps", "--n", 4, *chosen, "--out", file).status == 0
    questions = [json.loads(line) for line in file.read_text().splitlines()]
    assert [question["kind"] for question in questions] == ["forward", "state"] * 2
    assert {question["form"] for question in questions} == {"open"}


def test_what_shortcuts_give_is_printed(eai: Command, written: Path, tmp_path: Path) -> None:
    arguments = ("questions", "--domain", "lamps:lamps", "--n", 72, "--out", tmp_path / "q.jsonl")
    assert "Right without knowing the world, at best, in percent" in eai(*arguments).out
    chance = json.loads(eai(*arguments, "--json").out)["chance"]
    assert len(chance) == 36
    assert set(chance["inverse.choice"]) == {"guess", "names", "longest", "operator", "text", "unchanged"}
    assert chance["inverse.choice"]["guess"] == 25
    assert list(chance["inverse.open"]) == ["guess"]
    questions = [json.loads(line) for line in written.read_text().splitlines()]
    assert all(bool(each["shortcuts"]) == (each["form"] != "open") for each in questions)


def test_with_and_without_the_rules_are_compared(eai: Command, written: Path, tmp_path: Path) -> None:
    closed = tmp_path / "closed.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 62, "--no-rules", "--out", closed)
    assert eai("questions", *arguments).status == 0
    for name, file in (("told", written), ("closed", closed)):
        questions = [json.loads(line) for line in file.read_text().splitlines()]
        answers = tmp_path / f"{name}_outputs.json"
        rows = [{"identifier": q["id"], "llm_output": json.dumps(q["answer"])} for q in questions]
        answers.write_text(json.dumps(rows if name == "told" else rows[:20]))
        assert eai("questions", "score", file, answers, "--out", tmp_path / name).status == 0
    (found,) = json.loads(eai("compare", tmp_path / "told", tmp_path / "closed", "--json").out)
    assert found["tasks"] == 62
    other = tmp_path / "other.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 62, "--seed", 1, "--out", other)
    assert eai("questions", *arguments).status == 0
    assert eai("questions", "score", other, answers, "--out", tmp_path / "other").status == 0
    assert eai("compare", tmp_path / "told", tmp_path / "other").status == 2


def test_help_tells_of_every_command(eai: Command) -> None:
    for arguments in (("--help",), ()):
        told = eai("questions", *arguments)
        assert all(name in told.out + told.err for name in ("write", "run", "score"))


def test_the_gold_answers_are_all_right(eai: Command, written: Path, tmp_path: Path) -> None:
    out = tmp_path / "answers"
    asked = in_own_process("questions", "run", written, "--model", "eai/oracle", "--out", out, "--json")
    assert asked.status == 0, asked.err
    assert json.loads(asked.out)["overall"]["exact"] == {"value": 100.0, "numerator": 72, "denominator": 72}
    out /= "eai_oracle"
    records = [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]
    assert len(records) == 72
    assert all(record["exact"] and record["readable"] and not record["repairs"] for record in records)
    scored = eai("questions", "score", written, out / "eai_oracle_outputs.json", "--json")
    assert json.loads(scored.out) == json.loads(asked.out)
    table = eai("questions", "score", written, out / "eai_oracle_outputs.json").out
    assert "eai_oracle: 72 of 72 questions answered" in table
    assert "landmarks" in table


NOISY = ("--model", "eai/noisy", "-M", "rate=0.5", "--json")


@pytest.mark.parametrize("kept", [0.3, *swept(0.0, 0.9)])
def test_a_run_that_was_killed_comes_to_the_same_end(written: Path, tmp_path: Path, kept: float) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert in_own_process("questions", "run", written, *NOISY, "--out", whole).status == 0
    journal = (whole / "eai_noisy" / "answers.jsonl").read_bytes()
    cut = journal[
        : int(kept * len(journal))
    ]  # in the middle of a line, as a process that is killed leaves it
    (killed / "eai_noisy").mkdir(parents=True)
    (killed / "eai_noisy" / "answers.jsonl").write_bytes(cut)
    resumed = in_own_process("questions", "run", written, *NOISY, "--out", killed)
    assert resumed.status == 0, resumed.err
    for name in ("records.jsonl", "summary.json", "eai_noisy_outputs.json"):
        assert (killed / "eai_noisy" / name).read_bytes() == (whole / "eai_noisy" / name).read_bytes()
    again = (killed / "eai_noisy" / "answers.jsonl").read_bytes()
    assert again.startswith(cut[: cut.rfind(b"\n") + 1])
    assert (again.count(b"\n"), journal.count(b"\n")) == (72, 72)
    assert 20 < json.loads(resumed.out)["overall"]["exact"]["value"] < 75


def test_what_is_answered_is_not_asked_again(written: Path, tmp_path: Path) -> None:
    for limit in (("--limit", 5), (), ()):
        outcome = in_own_process("questions", "run", written, *NOISY, "--out", tmp_path, *limit)
        assert outcome.status == 0, outcome.err
        wanted = 5 if limit else 72
        assert (tmp_path / "eai_noisy" / "answers.jsonl").read_bytes().count(b"\n") == wanted
    assert len(list((tmp_path / "eai_noisy" / "logs").iterdir())) == 2  # the last run needed no other


@pytest.mark.skipif(sys.platform == "win32", reason="sends a signal")
def test_an_interrupt_says_how_to_go_on(written: Path, tmp_path: Path) -> None:
    command = ["questions", "run", str(written), *NOISY, "--out", str(tmp_path), "--max-connections", "1"]
    process = subprocess.Popen(
        [sys.executable, "-c", "from eai.cli import main; main()", *command],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    journal = tmp_path / "eai_noisy" / "answers.jsonl"
    try:
        assert wait_until(journal.exists), "no answer ever came"
        os.killpg(process.pid, signal.SIGINT)
        printed, told = process.communicate(timeout=120)
    finally:
        process.kill()
        process.communicate()
    if process.returncode:  # it may have been at its end
        assert (process.returncode, printed) == (130, "")
        assert told.splitlines()[-1] == "eai: interrupted; the same command goes on from here"
    assert in_own_process(*command).status == 0
    assert journal.read_bytes().count(b"\n") == 72


def test_a_question_without_an_answer_is_wrong(eai: Command, written: Path, tmp_path: Path) -> None:
    first = json.loads(written.read_text().splitlines()[0])
    answers = tmp_path / "me_outputs.json"
    answers.write_text(json.dumps([{"identifier": first["id"], "llm_output": first["answer"][0]}]))
    outcome = eai("questions", "score", written, answers, "--out", tmp_path / "scored", "--json")
    assert json.loads(outcome.out)["overall"]["exact"] == {
        "value": 100 / 72,
        "numerator": 1,
        "denominator": 72,
    }
    summary = json.loads((tmp_path / "scored" / "summary.json").read_text())
    assert summary["model"] == "me"
    assert summary["overall"]["unreadable"]["numerator"] == 0


def test_an_answer_to_no_question_is_told_what_ids_are_like(
    eai: Command, written: Path, tmp_path: Path
) -> None:
    first = json.loads(written.read_text().splitlines()[0])
    answers = tmp_path / "me_outputs.json"
    answers.write_text(json.dumps([{"identifier": "27_2", "llm_output": "yes"}]))
    outcome = eai("questions", "score", written, answers)
    assert outcome.status == 2
    assert (
        f"row 1: identifier '27_2' is not one of the questions, which have ids such as '{first['id']}'"
        in (outcome.err)
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--domain", "lamp", "--out", "q.jsonl"), "'lamp' is no benchmark"),
        (("score", "none.jsonl", "me_outputs.json"), "none.jsonl: cannot be read"),
        (("run", "none.jsonl", "--model", "eai/oracel", "--out", "o"), "did you mean eai/oracle"),
    ],
)
def test_what_cannot_be_used_is_told_in_a_line(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = eai("questions", *arguments)
    assert outcome.status == 2
    assert message in outcome.err


def test_a_model_without_answers_says_so(written: Path, tmp_path: Path) -> None:
    arguments = ("--model", "eai/planner", "--out", tmp_path, "--limit", 1)
    outcome = in_own_process("questions", "run", written, *arguments)
    assert outcome.status == 1
    assert "1 question not answered: InputError: eai/planner has no answers" in outcome.err
