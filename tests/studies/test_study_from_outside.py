"""A study that another distribution brings: its label, its option and its summary are wherever ours are."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from by_path import ROOT
from eai.base.store import DataPackStore
from eai.results.records import read_records
from processes import Outcome

pytest.importorskip("inspect_ai")

MODULE = ROOT / "tests" / "studies" / "terse.py"
LABEL = "characters-90"
SUITE = Path("behavior", "action_sequencing", "eai_noisy")
WHAT = "--domain behavior --ability action_sequencing --limit 3 --set eai --quiet --model eai/noisy"


@pytest.fixture(scope="module")
def runs(data_store: DataPackStore, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain run, a run of the study, and a run that combines it with another study."""
    folder = tmp_path_factory.mktemp("outside")
    (folder / "terse.py").write_text(MODULE.read_text(encoding="utf-8"), encoding="utf-8")
    about = folder / "terse-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: terse\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text("[eai.studies]\nterse = terse:TERSE\n", encoding="utf-8")
    limit = "--with terse.characters=90"
    for choices in ("", limit, f"{limit} --with replanning.replans=1"):
        done = command(f"run {WHAT} {choices} --out @/runs", folder)
        assert done.status == 0, done.err
    return folder


def command(text: str, folder: Path) -> Outcome:
    """Run a command in a process that finds the study's distribution."""
    words = [sys.executable, "-m", "eai", *text.replace("@", f"{folder}").split()]
    environment = {**os.environ, "PYTHONPATH": f"{folder}", "COLUMNS": "200"}
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
    return Outcome(done.returncode, done.stdout, done.stderr)


def rows_of(file: Path) -> list[dict[str, Any]]:
    with file.open(encoding="utf-8", newline="") as lines:
        return list(csv.DictReader(lines))


def test_a_study_of_another_distribution_fits_in_a_short_module() -> None:
    assert len(MODULE.read_text(encoding="utf-8").splitlines()) <= 60


def test_the_label_of_an_external_study_names_the_folder_of_its_run(runs: Path) -> None:
    folders = {path.parent.relative_to(runs / "runs" / SUITE) for path in runs.rglob("summary.json")}
    assert folders == {Path(), Path(LABEL), Path(f"replans-1-restart-explained+{LABEL}")}


def test_records_contain_label_option_and_summary_of_an_external_study(runs: Path) -> None:
    lines = (runs / "runs" / SUITE / LABEL / "records.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 3
    for line in map(json.loads, lines):
        excess = max(0, len(line["response"]) - 90)
        options = {"characters": 90}
        assert line["study"] == {"terse": {"label": LABEL, "options": options, "summary": {"excess": excess}}}
    assert any(json.loads(line)["study"]["terse"]["summary"]["excess"] for line in lines)
    summary = json.loads((runs / "runs" / SUITE / LABEL / "summary.json").read_text(encoding="utf-8"))
    assert summary["study"] == {"terse": {"label": LABEL, "options": {"characters": 90}}}


def test_records_of_an_external_study_are_read_without_the_study(runs: Path) -> None:
    (record, *_) = read_records(runs / "runs" / SUITE / LABEL / "records.jsonl")
    part = record.settings_by_study["terse"]
    assert (part.label, part.options) == (LABEL, {"characters": 90})
    assert part.summary == {"excess": max(0, len(record.response) - 90)}


def test_scores_in_a_log_contain_an_external_study(runs: Path) -> None:
    """The log of the run of the study is the second."""
    log = sorted((runs / "runs" / "logs").glob("*.eval"))[1]
    done = command(f"score {log} --domain behavior --ability action_sequencing --out @/again", runs)
    assert done.status == 0, done.err
    first = {
        each.task_id: each.settings_by_study
        for each in read_records(runs / "runs" / SUITE / LABEL / "records.jsonl")
    }
    scored = {each.task_id: each.settings_by_study for each in read_records(runs / "again" / "records.jsonl")}
    assert {task_id: scored[task_id] for task_id in first} == first


def test_tidy_tables_contain_the_label_of_an_external_study(runs: Path) -> None:
    assert command("analyze table @/runs --out @/table", runs).status == 0
    labels = {row["experiment"] for row in rows_of(runs / "table" / "answers.csv")}
    assert labels == {"", LABEL, f"replans-1-restart-explained+{LABEL}"}


def test_reports_contain_the_label_of_an_external_study(runs: Path) -> None:
    done = command("report @/runs --out @/report --no-prompts", runs)
    assert done.status == 0, done.err
    tables = json.loads((runs / "report" / "tables.json").read_text(encoding="utf-8"))["tables"]
    (named,) = (table for table in tables if table["name"].startswith("experiments_"))
    models = [row["model"] for row in named["rows"]]
    assert models == ["eai/noisy", f"eai/noisy, {LABEL}", f"eai/noisy, replans-1-restart-explained+{LABEL}"]


def test_comparisons_contain_the_label_of_an_external_study(runs: Path) -> None:
    one = runs / "runs" / SUITE
    done = command(f"compare {one}/records.jsonl {one}/{LABEL}", runs)
    assert f"eai/noisy, {LABEL}" in done.out, done.err


def test_its_analysis_reads_its_summaries(runs: Path) -> None:
    done = command(f"analyze terse @/runs/{SUITE}/{LABEL} --out @/terse", runs)
    assert done.status == 0, done.err
    (row,) = rows_of(runs / "terse" / "terse.csv")
    made = read_records(runs / "runs" / SUITE / LABEL / "records.jsonl")
    assert row["run"] == f"eai/noisy, {LABEL}"
    assert int(row["excess"]) == sum(each.summaries["terse"]["excess"] for each in made)
