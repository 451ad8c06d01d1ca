from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from command_line import Command
from eai.base.store import DataPackStore


@pytest.fixture
def offline(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No package index but an empty folder, and no store."""
    (tmp_path / "index").mkdir()
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "index"))
    monkeypatch.setenv("UV_OFFLINE", "1")
    monkeypatch.setenv("UV_NO_INDEX", "1")
    monkeypatch.setenv("EAI_DATA_DIR", str(tmp_path / "store"))


@pytest.mark.usefixtures("activity_store")
def test_fetching_what_is_there_says_so(eai: Command, data_store: DataPackStore) -> None:
    outcome = eai("data", "fetch", "--data", data_store.folder)
    assert outcome == (0, f"everything is there already ({data_store.folder})\n", "")


def test_info_says_where_the_data_is_and_what_it_is_made_from(
    eai: Command, data_store: DataPackStore
) -> None:
    out = eai("data", "info", "--data", data_store.folder).out
    assert f"folder: {data_store.folder}" in out
    assert "eai-eval==1.0.5" in out
    assert "ready" in out


def test_info_is_not_cut_where_there_is_little_room(
    eai: Command, data_store: DataPackStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    out = eai("data", "info", "--data", data_store.folder).out
    assert "…" not in out
    assert max(map(len, out.splitlines()[1:])) <= 60


def test_info_says_in_full_what_to_do_about_data_that_is_not_there(
    eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    out = eai("data", "info", "--data", tmp_path).out
    assert "missing" in out
    assert "ready" not in out
    assert f"{tmp_path / 'virtualhome.1.zip'}: no such data; run `eai data fetch`" in out


def test_stats_prints_the_papers_counts(eai: Command, data_store: DataPackStore) -> None:
    outcome = eai("data", "stats", "--data", data_store.folder)
    assert outcome.status == 0
    assert all(figure in outcome.out for figure in ("801", "340", "299", "162"))
    tables = json.loads(eai("data", "stats", "--json", "--data", data_store.folder).out)
    assert "virtualhome" in {table["domain"].lower() for table in tables}


def test_stats_of_one_benchmark_with_its_tasks_and_distributions(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    options = ("--by-task", "--distributions", "--out", tmp_path, "--data", data_store.folder)
    outcome = eai("data", "stats", "--domain", "behavior", *options)
    assert outcome.status == 0
    assert "VirtualHome" not in outcome.out
    assert "4,164.41" in outcome.out
    with (tmp_path / "behavior-tasks.csv").open(encoding="utf-8") as file:
        tasks = list(csv.DictReader(file))
    assert len(tasks) == 100
    assert sum(int(task["ground_goals"]) for task in tasks) == 673
    assert {path.name for path in tmp_path.glob("*.svg")} == {"behavior-names.svg", "behavior-numbers.svg"}
    (tmp_path / "file").write_text("")
    outcome = eai("data", "stats", "--by-task", "--out", tmp_path / "file", "--data", data_store.folder)
    assert outcome.status == 2
    assert "cannot be written" in outcome.err


def test_validate_finds_nothing_wrong(eai: Command, data_store: DataPackStore) -> None:
    outcome = eai("data", "info", "--check", "--data", data_store.folder)
    assert outcome == (0, "the data set is as published\n", "")


@pytest.mark.usefixtures("offline")
def test_without_data_and_network_one_line_says_what_to_do(eai: Command, tmp_path: Path) -> None:
    (tmp_path / "m_outputs.json").write_text(json.dumps([{"identifier": "27_2", "llm_output": ""}]))
    answers = (
        "score",
        tmp_path / "m_outputs.json",
        "--domain",
        "virtualhome",
        "--ability",
        "action_sequencing",
    )
    for command in (("data", "fetch"), answers):
        outcome = eai(*command)
        assert outcome.status == 2
        *progress, line = [line for line in outcome.err.splitlines() if line.strip()]
        assert all(each.startswith("fetching ") for each in progress)
        assert line.startswith("eai: ")
        assert "--from" in line


@pytest.mark.usefixtures("offline")
def test_a_place_without_the_archive_is_named(eai: Command, tmp_path: Path) -> None:
    outcome = eai("data", "fetch", "--from", tmp_path / "nowhere")
    assert outcome.status == 2
    assert "nowhere" in outcome.err
