from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest
from typer.testing import CliRunner

from eai.base.errors import InputError
from eai.cli import app
from record_files import write_records
from results.verdicts import whole
from studies.report.samples import action_run, goal_run, operator_run, subgoal_run, write_runs

RUNNER = CliRunner(env={"COLUMNS": "100"})


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    return write_runs(tmp_path, [action_run("first"), action_run("second"), goal_run()])


def test_compare_prints_both_runs_and_the_tasks_that_differ(runs: Path) -> None:
    result = RUNNER.invoke(app, ["compare", str(runs / "run0"), str(runs / "run1"), "--tasks", "2"])
    assert result.exit_code == 0
    assert "A first, 12/12 answered\nB second, 12/12 answered\n" in re.sub(r" +\n", "\n", result.output)
    assert "exact McNemar" in result.output
    assert "11 tasks of 4 names" in result.output
    assert "independent:" in result.output
    assert "Older records" not in result.output
    assert "task success only in first (4): 0_1 name 0, 3_1 name 3 … and 2 more" in result.output
    assert "1.000" in result.output


def test_old_records_get_a_note_on_their_intervals(tmp_path: Path) -> None:
    """Their tasks count as independent, which readers of intervals must know."""
    old = [[replace(each, task=None) for each in action_run(model)] for model in ("first", "second")]
    runs = write_runs(tmp_path / "runs", old)
    compared = RUNNER.invoke(app, ["compare", str(runs / "run0"), str(runs / "run1")])
    assert "11 tasks of" not in compared.output
    assert "Older records" in compared.output
    listed = RUNNER.invoke(app, ["report", str(runs)])
    assert "2 of 2 runs have older records" in " ".join(listed.output.split())
    out = tmp_path / "out"
    command = ["report", str(runs), "--out", str(out), "--no-prompts", "--no-plots"]
    assert RUNNER.invoke(app, command).exit_code == 0
    assert "2 of 2 runs have older records" in (out / "report.md").read_text(encoding="utf-8")


def test_compare_counts_one_task_in_the_singular(tmp_path: Path) -> None:
    runs = write_runs(tmp_path, [action_run(model)[:1] for model in ("first", "second")])
    result = RUNNER.invoke(app, ["compare", str(runs / "run0"), str(runs / "run1")])
    assert re.search(r": 1 task\b(?!s)", result.output), result.output


def test_compare_refuses_runs_without_a_common_suite(runs: Path) -> None:
    result = RUNNER.invoke(app, ["compare", str(runs / "run0"), str(runs / "run2")])
    assert "expected records of the same domain, ability and protocol" in str(result.exception)


def test_compare_refuses_several_models_on_one_side(runs: Path) -> None:
    result = RUNNER.invoke(app, ["compare", str(runs), str(runs / "run1")])
    assert "expected one run" in str(result.exception)


def test_a_report_lists_runs_and_paper_models_by_rank(runs: Path) -> None:
    alone = RUNNER.invoke(app, ["report", str(runs)])
    assert alone.exit_code == 0
    assert "VirtualHome, protocol strict" in alone.output
    assert "(paper)" not in alone.output
    both = RUNNER.invoke(app, ["report", str(runs), "--paper"])
    assert both.output.count("(published)") == 18
    assert "(paper)" not in both.output
    as_json = json.loads(RUNNER.invoke(app, ["report", str(runs), "--json"]).stdout)
    assert {table["name"] for table in as_json["tables"]} == {"overview"}
    old = write_runs(runs / "old", [action_run("third", "eai-1.0.5")])
    assert RUNNER.invoke(app, ["report", str(old), "--paper"]).output.count("(paper)") == 18


def test_plots_that_cannot_be_added_to_the_report_are_an_error(
    runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk is no missing library, without which the report only lacks its plots."""
    pytest.importorskip("matplotlib")
    full = InputError("report.md: cannot be written (No space left on device)")
    monkeypatch.setattr("eai.studies.report.plots.write_files_atomically", Mock(side_effect=full))
    result = RUNNER.invoke(app, ["report", str(runs), "--out", str(runs / "out")])
    assert result.exception is full


def test_unanswered_tasks_are_reported_wherever_a_run_is_shown(tmp_path: Path) -> None:
    records = [replace(record, suite_size=20) for record in action_run("part")]
    write_records(tmp_path / "part.jsonl", records)
    write_records(tmp_path / "whole.jsonl", whole(action_run("whole")))
    part, other = str(tmp_path / "part.jsonl"), str(tmp_path / "whole.jsonl")
    said = "only 12 of 20 tasks were asked; the run is not ranked."
    leaderboard = RUNNER.invoke(app, ["report", part, other])
    assert f"¹ Action sequencing: {said}" in leaderboard.output
    assert re.search(r"\n +part¹ +12/20 ", leaderboard.output)
    assert f"A: {said}" in RUNNER.invoke(app, ["compare", part, other]).output
    arguments = ["report", part, other, "--out", str(tmp_path / "out"), "--no-plots", "--no-prompts"]
    assert RUNNER.invoke(app, arguments).exit_code == 0
    page = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    assert said in page
    assert "|  | part¹ | 12/20 |" in page
    assert r" & part\textsuperscript{1} & 12/20 & " in (tmp_path / "out" / "tables.tex").read_text("utf-8")


def test_a_run_with_only_excluded_tasks_is_reported_under_both_protocols(tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run("first", name)[-1:] for name in ("strict", "eai-1.0.5")])
    done = RUNNER.invoke(app, ["report", str(runs), "--no-prompts", "--out", str(tmp_path / "report")])
    assert done.exit_code == 0, done.exception
    text = (tmp_path / "report" / "report.md").read_text(encoding="utf-8")
    (row,) = re.findall(r"\|.*Task success.*\|", text)
    assert row.count("–") == 2


def test_compare_names_suites_of_one_side_in_their_order(tmp_path: Path) -> None:
    one = write_runs(tmp_path / "one", [goal_run(), action_run(), subgoal_run(), operator_run()])
    other = write_runs(tmp_path / "other", [action_run("second"), action_run("second", "eai-1.0.5")])
    lines = RUNNER.invoke(app, ["compare", str(one), str(other)]).stderr.splitlines()
    suites = [line.removeprefix("only one side has ") for line in lines if line.startswith("only one side")]
    abilities = ("goal_interpretation", "subgoal_decomposition", "transition_modeling")
    assert [text.partition(", ")[0].partition(" ")[2] for text in suites] == [*abilities, "action_sequencing"]
