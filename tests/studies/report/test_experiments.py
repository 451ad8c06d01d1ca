"""Experiments have tables of their own; all other tables, ranks and plots leave them out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from eai.abilities.attempt import Attempt
from eai.abilities.experiment import Experiment
from eai.cli import app
from eai.results.record import Record
from eai.results.runs import read_runs
from eai.studies.report.explorer import ExplorerPageData, build_explorer_page
from experiments import experiment
from explorer_pages import read_explorer
from studies.report.samples import RIGHT, WRONG, action_run, write_runs

RUNNER = CliRunner()
REPLANNING = experiment(3, feedback="explained")
LABEL = "first, replans-3-restart-explained"


def all_right(tried: Experiment) -> list[Record]:
    """The first model's run, asked again until every answer is right."""
    return [
        replace(record, experiment=tried, verdict=record.verdict if record.verdict.excluded else RIGHT)
        for record in action_run("first")
    ]


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    return write_runs(tmp_path / "runs", [action_run("first"), action_run("second"), all_right(REPLANNING)])


def report(runs: Path, out: Path) -> dict[str, list[str]]:
    """Return the models of each table, and the other files of the report."""
    result = RUNNER.invoke(app, ["report", str(runs), "--out", str(out), "--no-prompts", "--paper"])
    assert result.exit_code == 0, result.output
    tables = json.loads((out / "tables.json").read_text(encoding="utf-8"))["tables"]
    return {
        table["name"]: [row["model"] for row in table["rows"] if row["source"] == "run"] for table in tables
    }


def test_an_experiment_has_its_own_table_below_the_plain_run(tmp_path: Path, runs: Path) -> None:
    models = report(runs, tmp_path / "out")
    assert models.pop("experiments_action_sequencing_trajectory") == ["first", LABEL]
    assert not any(LABEL in names for names in models.values())
    assert models["overview"] == ["second", "first"] or models["overview"] == ["first", "second"]


def test_experiments_change_no_other_table_of_a_report(tmp_path: Path, runs: Path) -> None:
    with_them = report(runs, tmp_path / "with")
    (runs / "run2" / "records.jsonl").unlink()
    without = report(runs, tmp_path / "without")
    with_them.pop("experiments_action_sequencing_trajectory")
    assert with_them == without
    for plot in sorted((tmp_path / "without" / "plots").glob("*.svg")):
        assert plot.read_bytes() == (tmp_path / "with" / "plots" / plot.name).read_bytes()


def test_a_report_can_consist_of_experiments_only(tmp_path: Path) -> None:
    only = write_runs(tmp_path / "only", [all_right(REPLANNING)])
    assert report(only, tmp_path / "out").keys() >= {"experiments_action_sequencing_trajectory"}
    assert "## Outcomes of answers" not in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")


def test_main_results_leave_experiments_out_with_a_note(runs: Path) -> None:
    result = RUNNER.invoke(app, ["report", str(runs)])
    assert "replans" not in result.output
    assert "left out: 1 experiment" in result.stderr


def test_experiments_that_differ_are_different_runs(tmp_path: Path) -> None:
    seeds = [experiment(3, feedback="explained", slip=0.1, slip_seed=seed) for seed in (0, 1)]
    both = write_runs(tmp_path / "seeds", [all_right(tried) for tried in seeds])
    found = report(both, tmp_path / "out")["experiments_action_sequencing_trajectory"]
    assert found == [f"{LABEL}+slip-0.1-seed-{seed}" for seed in (0, 1)]


def test_runs_with_other_prompt_sets_are_never_joined(tmp_path: Path) -> None:
    """Each set has a row of its own, named after the set, in no ranking of plain runs."""
    sets = ["eai-brief", "facts", "short"]
    asked = [all_right(experiment(prompt_name=name)) for name in sets]
    runs = write_runs(tmp_path / "runs", [action_run("first"), *asked])
    models = report(runs, tmp_path / "out")
    names = models.pop("experiments_action_sequencing_trajectory")
    assert names == ["first", *[f"first, prompt-{name}" for name in sets]]
    assert all(names == ["first"] for names in models.values() if names)
    counts = [len(run.records) for run in read_runs([runs])]
    assert counts == [len(action_run("first"))] * 4


def test_the_explorer_shows_each_attempt_as_an_answer(tmp_path: Path) -> None:
    """Two of one task; a task that was tried once has its answer alone."""
    once, *others = all_right(REPLANNING)
    twice = replace(once, attempts=(Attempt("first", WRONG), Attempt("answer 0", RIGHT)))
    write_runs(tmp_path / "runs", [[twice, *others]])
    data = ExplorerPageData()
    for run in read_runs([tmp_path / "runs"]):
        data.add_run(run)
    content = read_explorer("".join(build_explorer_page(data.format_data_as_base64_lines())))
    attempts = [answer.get("A", []) for answer in content["runs"][0]["answers"]]
    assert [[each["o"] for each in of_task] for of_task in attempts][:2] == [["wrong_order", "success"], []]
    assert [each["r"] for each in attempts[0]] == ["first", "answer 0"]


def test_comparisons_name_the_experiment(runs: Path) -> None:
    result = RUNNER.invoke(app, ["compare", str(runs / "run0"), str(runs / "run2")])
    assert f"B {LABEL}," in result.output
    beside = RUNNER.invoke(app, ["compare", str(runs), str(runs / "run1")])
    assert "expected one run" in str(beside.exception)
