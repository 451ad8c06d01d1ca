from __future__ import annotations

import sys
from pathlib import Path

import pytest

from cli.conftest import Command
from report.samples import action_run, goal_run, operator_run, write_runs


def test_tables_have_the_same_bytes_each_time(eai: Command, tmp_path: Path) -> None:
    runs = write_runs(tmp_path / "runs", [action_run("first"), goal_run()])
    for folder in ("one", "two"):
        outcome = eai("analyze", "table", runs, "--out", tmp_path / folder)
        assert outcome.status == 0
        assert outcome.out.startswith("16 answers, 44 steps, 22 goals, 0 atoms, 0 clauses; in ")
    for file in sorted((tmp_path / "one").iterdir()):
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()
    assert {file.name for file in (tmp_path / "one").iterdir()} == {
        f"{name}.csv" for name in ("answers", "steps", "goals", "atoms", "clauses")
    }


@pytest.mark.parametrize("name", ["cofactors", "errors", "goals"])
def test_analyses_have_the_same_bytes_each_time(eai: Command, tmp_path: Path, name: str) -> None:
    pytest.importorskip("scipy")
    records = [action_run("first"), action_run("second"), goal_run(), operator_run()]
    runs = write_runs(tmp_path / "runs", records)
    for folder in ("one", "two"):
        outcome = eai("analyze", name, runs, "--out", tmp_path / folder)
        assert (outcome.status, outcome.err) == (0, "")
    written = sorted((tmp_path / "one").iterdir())
    assert [file.read_bytes() for file in written] == [
        (tmp_path / "two" / file.name).read_bytes() for file in written
    ]
    assert {f"{name}.md", f"{name}.json"} < {file.name for file in written}


def test_a_missing_extra_is_one_line(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = write_runs(tmp_path / "runs", [action_run("first"), action_run("second")])
    monkeypatch.setitem(sys.modules, "numpy", None)
    outcome = eai("analyze", "cofactors", runs, "--out", tmp_path / "out")
    assert outcome.status == 2
    assert outcome.err == "eai: this analysis needs numpy: pip install 'embodied-agent-interface[analysis]'\n"
