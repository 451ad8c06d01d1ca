"""Runs of world-model questions in reports and comparisons, as those of any ability."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from by_path import ROOT
from command_line import Command
from eai.benchmarks.registry import find_benchmark
from eai.extensions.questions.question import format_gold_answer, questions_to_bytes
from eai.extensions.questions.writer import QuestionGenerator
from explorer_pages import read_explorer

LAMPS = ROOT / "examples" / "lamps"


@pytest.fixture
def scored(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the records of a model with right answers only, and of a model with mostly right answers."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(LAMPS)
    asked = list(QuestionGenerator(find_benchmark("lamps:lamps")).write_questions(number=36))
    file = tmp_path / "questions.jsonl"
    file.write_bytes(questions_to_bytes(asked))
    for name, kept in (("sure", 36), ("unsure", 20)):
        answers = {each.id: format_gold_answer(each) if n < kept else "?" for n, each in enumerate(asked)}
        rows = [{"identifier": name, "llm_output": text} for name, text in answers.items()]
        Path(f"{name}_outputs.json").write_text(json.dumps(rows))
        suite = ("--ability", "world_model", "--domain", file)
        outcome = eai("score", f"{name}_outputs.json", *suite, "--out", f"runs/{name}")
        assert outcome.status == 0, outcome.err
    return Path("runs")


def test_a_report_has_a_table_with_intervals_and_chance(eai: Command, scored: Path) -> None:
    outcome = eai("report", scored, "--out", "report", "--no-plots")
    assert (outcome.status, outcome.out) == (
        0,
        "2 runs, 1 table, 0 plots; open report/explorer.html\n",
    )
    page = Path("report/report.md").read_text()
    assert "### World-model questions" in page
    (table,) = json.loads(Path("report/tables.json").read_text())["tables"]
    assert [row["model"] for row in table["rows"]] == ["sure", "unsure"]
    header = next(line for line in page.splitlines() if line.startswith("| # | model |"))
    assert all(name in header for name in ("Right", "Forward", "Landmarks", "Choice", "Guess", "Longest"))
    assert r"World-model questions" in Path("report/tables.tex").read_text()
    explorer = read_explorer(Path("report/explorer.html").read_text(encoding="utf-8"))
    assert {run["ability"] for run in explorer["runs"]} == {"world_model"}


def test_of_two_models_one_may_be_shown_in_latex(eai: Command, scored: Path) -> None:
    arguments = ("report", scored, "--out", "report", "--no-plots", "--models")
    assert eai(*arguments, "unsure").status == 0
    latex = Path("report/tables.tex").read_text()
    assert "unsure" in latex
    assert "sure" not in latex.replace("unsure", "").replace("measure", "")
    refused = eai(*arguments, "unsur")
    assert refused.status == 2
    assert "--models: no table has 'unsur'" in refused.err


def test_the_leaderboard_ranks_them(eai: Command, scored: Path) -> None:
    (table,) = json.loads(eai("report", scored, "--json").out)["tables"]
    assert (table["name"], [row["model"] for row in table["rows"]]) == ("world_model", ["sure", "unsure"])


def test_models_are_compared_by_kind(eai: Command, scored: Path) -> None:
    outcome = eai("compare", scored / "sure", scored / "unsure", "--json")
    (found,) = json.loads(outcome.out)
    assert (found["ability"], found["tasks"], found["names"]) == ("world_model", 36, 2)
    by_metric = {each["metric"]: each for each in found["differences"]}
    assert len(by_metric) == 13
    whole = by_metric["right"]
    assert (whole["a"]["numerator"], whole["b"]["numerator"]) == (36, 20)
    assert (len(whole["only_a"]), whole["only_b"]) == (16, [])
    table = eai("compare", scored / "sure", scored / "unsure").out
    assert "lamps-questions world_model, protocol strict: 36 tasks of 2 names" in table


def test_records_of_the_older_form_are_refused_in_a_line(eai: Command, scored: Path) -> None:
    (scored / "sure" / "records.jsonl").write_text('{"ability": "world_model", "id": "a"}\n')
    outcome = eai("report", scored, "--out", "report", "--no-plots")
    assert outcome.status == 2
    assert "records.jsonl, line 1: " in outcome.err
