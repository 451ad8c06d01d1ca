from __future__ import annotations

from pathlib import Path

from cli.conftest import Command
from report.samples import action_run, goal_run, write_runs


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
