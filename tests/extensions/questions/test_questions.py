from __future__ import annotations

import json
from pathlib import Path

import pytest

from by_path import ROOT
from command_line import Command
from processes import eai as in_own_process
from sweeps import sweep, swept

LAMPS = ROOT / "examples" / "lamps"


@pytest.fixture
def written(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two questions of each kind and form about the example world."""
    monkeypatch.chdir(LAMPS)
    file = tmp_path / "questions.jsonl"
    outcome = eai("export", "questions", "--domain", "lamps:lamps", "--n", 72, "--out", file)
    assert outcome.status == 0, outcome.err
    assert outcome.out.endswith(
        f"72 questions written to {file}, each with its right answer\n"
        f"next: eai run --model eai/oracle --ability world_model --domain {file}\n"
    )
    return file


def test_equal_options_write_equal_questions(eai: Command, written: Path, tmp_path: Path) -> None:
    again = tmp_path / "again" / "questions.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 72, "--seed", 0, "--out", again)
    assert eai("export", "questions", *arguments).status == 0
    assert again.read_bytes() == written.read_bytes()


def test_questions_do_not_depend_on_the_order_of_sets(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(LAMPS)
    written = set()
    for seed in "123":
        file = tmp_path / f"{seed}.jsonl"
        arguments = ("--domain", "lamps:lamps", "--n", 72, "--out", file)
        outcome = in_own_process("export", "questions", *arguments, PYTHONHASHSEED=seed)
        assert outcome.status == 0, outcome.err
        written.add(file.read_bytes())
    assert len(written) == 1


def test_kinds_and_forms_can_be_chosen(eai: Command, written: Path, tmp_path: Path) -> None:
    file = tmp_path / "some.jsonl"
    chosen = ("--kind", "forward", "--kind", "state", "--form", "open")
    assert eai("export", "questions", "--domain", "lamps:lamps", "--n", 4, *chosen, "--out", file).status == 0
    questions = [json.loads(line) for line in file.read_text().splitlines()]
    assert [question["kind"] for question in questions] == ["forward", "state"] * 2
    assert {question["form"] for question in questions} == {"open"}


def test_the_rates_of_shortcuts_are_printed(eai: Command, written: Path, tmp_path: Path) -> None:
    arguments = ("export", "questions", "--domain", "lamps:lamps", "--n", 72, "--out", tmp_path / "q.jsonl")
    assert "Best rate without knowledge of the world, in percent" in eai(*arguments).out
    chance = json.loads(eai(*arguments, "--json").out)["chance"]
    assert len(chance) == 36
    assert set(chance["inverse.choice"]) == {"guess", "names", "longest", "operator", "text", "unchanged"}
    assert chance["inverse.choice"]["guess"] == 25
    assert list(chance["inverse.open"]) == ["guess"]
    questions = [json.loads(line) for line in written.read_text().splitlines()]
    assert all(bool(each["shortcuts"]) == (each["form"] != "open") for each in questions)


ASKED = ("--ability", "world_model", "--domain")


def test_with_and_without_the_rules_are_compared(eai: Command, written: Path, tmp_path: Path) -> None:
    closed = tmp_path / "closed.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 62, "--no-rules", "--out", closed)
    assert eai("export", "questions", *arguments).status == 0
    for name, file in (("told", written), ("closed", closed)):
        questions = [json.loads(line) for line in file.read_text().splitlines()]
        answers = tmp_path / f"{name}_outputs.json"
        rows = [{"identifier": q["id"], "llm_output": json.dumps(q["answer"])} for q in questions]
        answers.write_text(json.dumps(rows if name == "told" else rows[:20]))
        assert eai("score", answers, *ASKED, file, "--out", tmp_path / name).status == 0
    (found,) = json.loads(eai("compare", tmp_path / "told", tmp_path / "closed", "--json").out)
    assert (found["ability"], found["tasks"], found["names"]) == ("world_model", 62, 2)
    other = tmp_path / "other.jsonl"
    arguments = ("--domain", "lamps:lamps", "--n", 62, "--seed", 1, "--kind", "forward", "--out", other)
    assert eai("export", "questions", *arguments).status == 0
    for line in (questions := [json.loads(line) for line in other.read_text().splitlines()]):
        line["depth"] = 7
    other.write_text("".join(json.dumps(line) + "\n" for line in questions))
    assert eai("score", answers, *ASKED, other, "--out", tmp_path / "other").status == 2
    rows = [{"identifier": q["id"], "llm_output": "yes"} for q in questions]
    answers.write_text(json.dumps(rows))
    assert eai("score", answers, *ASKED, other, "--out", tmp_path / "other").status == 0
    refused = eai("compare", tmp_path / "told", tmp_path / "other")
    assert refused.status == 2
    assert (
        "expected scored answers to the same tasks of world_model, protocol strict, found none" in refused.err
    )


def test_help_names_the_command_that_writes_questions(eai: Command) -> None:
    for arguments in (("--help",), ()):
        told = eai("export", "questions", *arguments)
        assert "write" in told.out + told.err


def test_the_gold_answers_are_all_right(eai: Command, written: Path, tmp_path: Path) -> None:
    out = tmp_path / "answers"
    asked = in_own_process("run", *ASKED, written, "--model", "eai/oracle", "--out", out, "--json")
    assert asked.status == 0, asked.err
    out = out / "lamps-questions" / "world_model" / "eai_oracle"
    summary = json.loads((out / "summary.json").read_text())
    assert summary["right"].items() >= {"value": 100.0, "numerator": 72, "denominator": 72}.items()
    records = [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]
    assert len(records) == 72
    assert all(record["success"] and not record["error"] and not record["repairs"] for record in records)
    table = eai("score", out / "eai_oracle_outputs.json", *ASKED, written).out
    assert "lamps-questions, world-model questions, protocol strict" in table
    assert "landmarks" in table


NOISY = ("--model", "eai/noisy", "-M", "rate=0.5", "--quiet")


@pytest.mark.parametrize("kept", [0.3, *swept(0.0, 0.9)])
def test_a_run_that_was_killed_comes_to_the_same_end(written: Path, tmp_path: Path, kept: float) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    place = Path("lamps-questions", "world_model", "eai_noisy")
    assert in_own_process("run", *ASKED, written, *NOISY, "--out", whole).status == 0
    journal = (whole / place / "answers.jsonl").read_bytes()
    cut = journal[
        : int(kept * len(journal))
    ]  # in the middle of a line, as a process that is killed leaves it
    (killed / place).mkdir(parents=True)
    (killed / place / "answers.jsonl").write_bytes(cut)
    resumed = in_own_process("run", *ASKED, written, *NOISY, "--out", killed)
    assert resumed.status == 0, resumed.err
    assert (killed / place / "records.jsonl").read_bytes() == (whole / place / "records.jsonl").read_bytes()
    again = (killed / place / "answers.jsonl").read_bytes()
    assert again.startswith(cut[: cut.rfind(b"\n") + 1])
    assert (again.count(b"\n"), journal.count(b"\n")) == (72, 72)


def test_a_question_without_an_answer_is_wrong(eai: Command, written: Path, tmp_path: Path) -> None:
    first = json.loads(written.read_text().splitlines()[0])
    answers = tmp_path / "me_outputs.json"
    answers.write_text(json.dumps([{"identifier": first["id"], "llm_output": first["answer"][0]}]))
    assert eai("score", answers, *ASKED, written, "--out", tmp_path / "scored").status == 0
    summary = json.loads((tmp_path / "scored" / "summary.json").read_text())
    assert summary["right"] | {"numerator": 1, "denominator": 72} == summary["right"]
    assert (summary["model"], summary["parsing"]["numerator"]) == ("me", 0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--domain", "lamp", "--out", "q.jsonl"), "'lamp' is not a benchmark"),
    ],
)
def test_unusable_question_files_are_reported_in_one_line(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = eai("export", "questions", *arguments)
    assert outcome.status == 2
    assert message in outcome.err


def test_a_run_without_an_ability_names_the_one_to_give(eai: Command, written: Path, tmp_path: Path) -> None:
    refused = in_own_process("run", "--domain", written, "--model", "eai/oracle", "--out", tmp_path / "o")
    assert (refused.status, refused.err) == (
        2,
        f"eai: --domain {written}: it has no tasks for goal_interpretation; give --ability world_model\n",
    )


def test_answered_questions_are_not_asked_again(written: Path, tmp_path: Path) -> None:
    for limit in (("--limit", 5), (), ()):
        outcome = in_own_process("run", *ASKED, written, *NOISY, "--out", tmp_path / "o", *limit)
        assert outcome.status == 0, outcome.err
        journal = tmp_path / "o" / "lamps-questions" / "world_model" / "eai_noisy" / "answers.jsonl"
        assert journal.read_bytes().count(b"\n") == (5 if limit else 72)
    assert len(list((tmp_path / "o" / "logs").glob("*.eval"))) == 2  # the last run needed no other


def test_an_unknown_id_is_reported_with_an_example_id(eai: Command, written: Path, tmp_path: Path) -> None:
    first = json.loads(written.read_text().splitlines()[0])
    answers = tmp_path / "me_outputs.json"
    answers.write_text(json.dumps([{"identifier": "27_2", "llm_output": "yes"}]))
    outcome = eai("score", answers, *ASKED, written)
    assert outcome.status == 2
    assert f"'27_2' is not one of the tasks, which have ids such as '{first['id']}'\n" in outcome.err


@sweep
def test_a_model_without_answers_says_so(written: Path, tmp_path: Path) -> None:
    arguments = ("--model", "eai/planner", "--out", tmp_path, "--limit", 1)
    outcome = in_own_process("run", *ASKED, written, *arguments)
    assert outcome.status == 2
    assert "eai/planner has no answer to world_model" in outcome.err
