"""Runs of world-model questions in reports and comparisons, through the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.conftest import Command, eai
from eai.benchmark.registry import find_benchmark
from eai.errors import InputError
from eai.questions.answers import gold_text, noisy_text
from eai.questions.question import Question, questions_content
from eai.questions.records import read_question_run
from eai.questions.writer import Wanted, Writer
from eai.report.runs import read_runs

__all__ = ["eai"]

LAMPS = Path(__file__).parents[2] / "examples" / "lamps"


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Question]:
    """One question of each kind and form about the example world, in the working directory."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(LAMPS)
    questions = list(Writer(find_benchmark("lamps:lamps")).write(Wanted(number=36)))
    Path("questions.jsonl").write_bytes(questions_content(questions))
    return questions


@pytest.fixture
def scored(eai: Command, asked: list[Question]) -> Path:
    """The records of a model that is always right, and of one that mostly is."""
    for name, rate in (("sure", 0.0), ("unsure", 0.4)):
        answers = {each.id: noisy_text(each, rate, "seed") if rate else gold_text(each) for each in asked}
        rows = [{"identifier": name, "llm_output": text} for name, text in answers.items()]
        Path(f"{name}_outputs.json").write_text(json.dumps(rows))
        outcome = eai(
            "questions", "score", "questions.jsonl", f"{name}_outputs.json", "--out", f"runs/{name}"
        )
        assert outcome.status == 0, outcome.err
    return Path("runs")


def test_what_is_read_is_what_was_written(scored: Path, asked: list[Question]) -> None:
    run = read_question_run(scored / "sure" / "records.jsonl")
    assert (run.model, run.domain, len(run.results)) == ("sure", "lamps", 36)
    assert [(r.question.id, r.question.answer) for r in run.results] == [(q.id, q.answer) for q in asked]
    assert all(result.graded.exact for result in run.results)
    assert list(read_runs([scored])) == []  # for they are no runs of an ability


def test_a_report_has_a_table_by_kind_with_intervals_and_chance(eai: Command, scored: Path) -> None:
    outcome = eai("report", scored, "--out", "report")
    assert (outcome.status, outcome.out) == (
        0,
        "0 runs, 0 tables, 0 plots, 2 runs of questions; open report/report.md\n",
    )
    page = Path("report/report.md").read_text()
    assert "## World-model questions" in page
    assert "| kind | sure | 95 % | of | chance | unsure | 95 % | of | chance |" in page
    row = next(line for line in page.splitlines() if line.startswith("| all |"))
    cells = [cell.strip() for cell in row.strip("|").split("|")]
    assert (cells[1], cells[3], cells[7]) == ("100.0", "36", "36")
    assert cells[2].endswith("–100.0")
    assert cells[4] == cells[8]  # the same questions have the same chance
    told = json.loads(Path("report/questions.json").read_text())["questions"]
    assert [each["model"] for each in told] == ["sure", "unsure"]
    assert f"{told[1]['overall']['exact']['value']:.1f}" == cells[5]
    latex = Path("report/tables.tex").read_text()
    assert r"\multicolumn{4}{c}{sure} & \multicolumn{4}{c}{unsure} \\" in latex
    assert r"kind & right & 95 \% & of & chance & right & 95 \% & of & chance \\" in latex
    assert " & ".join(cells).replace("–", "--") in latex
    assert not Path("report/explorer.html").exists()


def test_of_two_models_one_may_be_shown_in_latex(eai: Command, scored: Path) -> None:
    assert eai("report", scored, "--out", "report", "--models", "unsure").status == 0
    latex = Path("report/tables.tex").read_text()
    assert "{sure}" not in latex
    assert "{unsure}" in latex
    outcome = eai("report", scored, "--out", "report", "--models", "unsur")
    assert outcome.status == 2
    assert "--models: no table has 'unsur'" in outcome.err


def test_the_explorer_says_where_questions_are(eai: Command, scored: Path) -> None:
    Path("plans_outputs.json").write_text('[{"identifier": "light", "llm_output": "[]"}]')
    plans = ("plans_outputs.json", "--domain", "lamps:lamps", "--ability", "action_sequencing")
    assert eai("score", *plans, "--out", "runs/plans").status == 0
    out = eai("report", "runs", "--out", "report", "--no-plots").out
    assert "1 run, 3 tables, 0 plots, 2 runs of questions" in out
    assert '"questions":2' in Path("report/explorer.html").read_text()


def test_models_are_compared_by_kind(eai: Command, scored: Path) -> None:
    outcome = eai("compare", scored / "sure", scored / "unsure", "--json")
    (found,) = json.loads(outcome.out)
    assert (found["ability"], found["tasks"], found["names"]) == ("world_model", 36, 2)
    by_metric = {each["metric"]: each for each in found["differences"]}
    assert len(by_metric) == 13
    whole = by_metric["all"]
    lost = len(whole["only_a"])
    assert (whole["a"]["numerator"], whole["b"]["numerator"]) == (36, 36 - lost)
    assert (lost > 0, whole["only_b"]) == (True, [])
    table = eai("compare", scored / "sure", scored / "unsure").out
    assert "lamps, world-model questions: 36 about 2 tasks" in table
    assert "questions about a task together" in " ".join(table.split())


def test_answers_to_other_questions_are_not_compared(eai: Command, scored: Path) -> None:
    other = scored / "unsure" / "records.jsonl"
    changed = other.read_text().replace('"questions_sha256": "', '"questions_sha256": "0')
    other.write_text(changed.replace('"title": "', '"title": "another '))
    outcome = eai("compare", scored / "sure", scored / "unsure")
    assert outcome.status == 2
    assert "both have records of" in outcome.err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"exact": true', '"exact": "so"', "line 1: exact: "),
        ('"kind": "forward"', '"kind": "foreward"', "line 1: kind: "),
        ("}\n", "}\n{", "line 2: expected a JSON object"),
    ],
)
def test_what_is_no_record_is_refused(scored: Path, old: str, new: str, message: str) -> None:
    path = scored / "sure" / "records.jsonl"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=r"records\.jsonl, ") as caught:
        read_question_run(path)
    assert message in str(caught.value)


def test_one_model_may_answer_the_same_questions_once(eai: Command, scored: Path) -> None:
    outcome = eai("report", scored, scored / "sure" / ".." / "sure" / "records.jsonl", "--out", "report")
    assert outcome.status == 2
    assert "sure has answered these questions in another file" in outcome.err
