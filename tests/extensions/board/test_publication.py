"""Results for Every Eval Ever, by its own schema, and for the Hugging Face Hub."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from typer.testing import CliRunner, Result

from eai.cli import app
from eai.results.record import Record
from studies.report.samples import HOSTILE, action_run, goal_run, operator_run, subgoal_run, write_runs

SCHEMA = json.loads((Path(__file__).parent / "every_eval_ever" / "eval.schema.json").read_text("utf-8"))
FILE = """\
by = "A Lab"
date = 2026-11-26
url = "https://lab.example"
logs = "https://lab.example/logs"
dataset = "lab/season-1"

[models]
first = "maker/first-large"
second = "maker/second"
"""


def by(model: str, run: list[Record]) -> list[Record]:
    """The same answers, of one model."""
    return [replace(each, model=model) for each in run]


def report(folder: Path, text: str, *runs: list[Record]) -> Result:
    (folder / "publish.toml").write_text(text, encoding="utf-8")
    records = str(write_runs(folder / "runs", runs))
    options = ("--about", str(folder / "publish.toml"), "--out", str(folder / "published"))
    return CliRunner().invoke(app, ["export", "results", records, *options])


def published(folder: Path, place: str) -> list[Any]:
    files = sorted((folder / "published").glob(place))
    return [yaml.safe_load(file.read_text(encoding="utf-8")) for file in files]


def files_of(folder: Path) -> list[Path]:
    return [path for path in (folder / "published").rglob("*") if path.is_file()]


def test_results_fit_the_schema_of_every_eval_ever(tmp_path: Path) -> None:
    runs = [by("first", run) for run in (action_run(), goal_run(), subgoal_run(), operator_run())]
    other = by("second", action_run("first", "eai-1.0.5"))
    result = report(tmp_path, FILE, *runs, other)
    assert result.exit_code == 0, result.output
    (first,) = published(tmp_path, "every_eval_ever/data/eai/maker/first-large/*.json")
    (second,) = published(tmp_path, "every_eval_ever/data/eai/maker/second/*.json")
    check = jsonschema.validators.validator_for(SCHEMA)(SCHEMA)
    for record in (first, second):
        assert [error.message for error in check.iter_errors(record)] == []
    assert first["schema_version"] == SCHEMA["version"]
    assert first["model_info"]["id"] == "maker/first-large"
    names = {result["evaluation_name"] for result in first["evaluation_results"]}
    assert "virtualhome_action_sequencing" in names
    assert len(names) == 4
    tasks = next(each for each in first["evaluation_results"] if each["evaluation_name"] in names)
    low_high = tasks["score_details"]["uncertainty"]["confidence_interval"]
    assert low_high["lower"] <= tasks["score_details"]["score"] <= low_high["upper"]


def test_the_hub_reads_a_score_a_suite(tmp_path: Path) -> None:
    assert report(tmp_path, FILE, action_run()).exit_code == 0
    (entries,) = published(tmp_path, "hugging_face/maker/first-large/.eval_results/eai-strict.yaml")
    (entry,) = entries
    assert entry["dataset"] == {"id": "lab/season-1", "task_id": "virtualhome_action_sequencing"}
    assert 0 < entry["value"] < 100
    assert entry["date"] == "2026-11-26"
    assert entry["source"] == {"url": "https://lab.example/logs", "name": "A Lab"}


def test_results_of_incomplete_suites_are_not_published(tmp_path: Path) -> None:
    records = write_runs(tmp_path / "runs", [action_run()]) / "run0" / "records.jsonl"
    lines = records.read_text(encoding="utf-8").splitlines(keepends=True)
    records.write_text("".join(lines[:-1]), encoding="utf-8")
    result = report(tmp_path, FILE)
    assert "no model named in this file answered all tasks of a suite" in str(result.exception)
    assert not (tmp_path / "published").exists()


def test_only_models_that_are_named_are_published_each_below_its_name(tmp_path: Path) -> None:
    runs = [by(name, action_run()) for name in ("../../outside", HOSTILE, "second")]
    assert report(tmp_path, FILE, *runs).exit_code == 0
    places = {path.relative_to(tmp_path / "published").parts[:5] for path in files_of(tmp_path)}
    assert places == {
        ("every_eval_ever", "data", "eai", "maker", "second"),
        ("hugging_face", "maker", "second", ".eval_results", "eai-strict.yaml"),
    }


def test_two_models_of_one_public_name_are_refused(tmp_path: Path) -> None:
    text = FILE.replace("maker/second", "maker/first-large")
    result = report(tmp_path, text, action_run(), by("second", action_run()))
    assert "several models or variants are published in hugging_face/maker/first-large/" in str(
        result.exception
    )
    assert not (tmp_path / "published").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("date = 2026-11-26\n", "by: is missing"),
        (f'organisation = "y"\n{FILE}', "organisation: unknown"),
        (FILE.replace("lab/season-1", "no owner"), "dataset"),
        (FILE.replace("maker/first-large", "../outside"), "models.first"),
        (FILE.partition("[models]")[0], "models: is missing"),
    ],
)
def test_a_file_of_another_form_is_refused(tmp_path: Path, text: str, said: str) -> None:
    result = report(tmp_path, text, action_run())
    assert result.exit_code != 0
    assert "publish.toml" in str(result.exception)
    assert said in str(result.exception)
