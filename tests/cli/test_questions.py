from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.conftest import Command
from processes import eai as in_own_process

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


def test_help_tells_of_every_command(eai: Command) -> None:
    for arguments in (("--help",), ()):
        told = eai("questions", *arguments)
        assert all(name in told.out + told.err for name in ("write", "run", "score"))


def test_the_gold_answers_are_all_right(eai: Command, written: Path, tmp_path: Path) -> None:
    out = tmp_path / "answers"
    asked = in_own_process("questions", "run", written, "--model", "eai/oracle", "--out", out, "--json")
    assert asked.status == 0, asked.err
    assert json.loads(asked.out)["overall"]["exact"] == {"value": 100.0, "numerator": 72, "denominator": 72}
    records = [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]
    assert len(records) == 72
    assert all(record["exact"] and record["readable"] and not record["repairs"] for record in records)
    scored = eai("questions", "score", written, out / "eai_oracle_outputs.json", "--json")
    assert json.loads(scored.out) == json.loads(asked.out)
    table = eai("questions", "score", written, out / "eai_oracle_outputs.json").out
    assert "eai_oracle: 72 of 72 questions answered" in table
    assert "landmarks" in table


def test_what_is_answered_is_not_asked_again(written: Path, tmp_path: Path) -> None:
    answers = tmp_path / "answers" / "eai_noisy_outputs.json"
    answers.parent.mkdir()
    first = json.loads(written.read_text().splitlines()[0])["id"]
    answers.write_text(json.dumps([{"identifier": first, "llm_output": "kept"}]))
    noisy = ("--model", "eai/noisy", "-M", "rate=0.5", "--out", answers.parent, "--json")
    outcome = in_own_process("questions", "run", written, *noisy)
    assert 20 < json.loads(outcome.out)["overall"]["exact"]["value"] < 75
    rows = json.loads(answers.read_text())
    assert len(rows) == 72
    assert rows[0] == {"identifier": first, "llm_output": "kept"}


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
    assert "1 question not answered" in outcome.err
