from __future__ import annotations

from pathlib import Path

from eai.abilities.protocol import Protocol
from eai.cli import app
from eai.extensions.reference.protocol import TASK_WITH_REMOVED_GOAL
from results.verdicts import SUCCEEDED, record
from studies.report.samples import write_runs
from studies.report.test_commands import RUNNER


def test_beside_the_paper_a_plan_misses_the_goal_that_only_the_paper_asked_for(tmp_path: Path) -> None:
    asked = record(TASK_WITH_REMOVED_GOAL, SUCCEEDED, domain="behavior", protocol=Protocol("eai-1.0.5"))
    folder = str(write_runs(tmp_path, [[asked]]))
    alone, both = (RUNNER.invoke(app, ["report", folder, *more]).output for more in ([], ["--paper"]))
    assert "100.0" in alone
    rows = [[line.split() for line in text.splitlines()] for text in (alone, both)]
    success, beside = (next(row[3] for row in found if row[1:2] == ["m"]) for found in rows)
    assert (success, beside) == ("100.0", "0.0")
