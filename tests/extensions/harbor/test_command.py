from __future__ import annotations

import json
from pathlib import Path

from command_line import Command
from eai.base.store import DataPackStore


def test_task_folders_for_harbor(eai: Command, data_store: DataPackStore, tmp_path: Path) -> None:
    asked = (
        "--domain",
        "virtualhome",
        "--ability",
        "acting",
        "--tasks",
        "27_2,339_1",
        "--out",
        tmp_path / "out",
    )
    told = eai("export", "harbor", *asked)
    assert told.out.splitlines() == [
        f"1 task written to {tmp_path / 'out'}",
        "left out: 1 task without a verified solution",
        f"build the image that scores answers from {tmp_path / 'out' / 'image'}",
    ]
    again = eai("export", "harbor", *asked)
    assert (again.status, again.err) == (2, f"eai: {tmp_path / 'out'}: expected a new or an empty folder\n")


def test_task_folders_that_are_scored_in_the_agents_box(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    how = (
        "--ability",
        "goal_interpretation",
        "--tasks",
        "27_2",
        "--out",
        tmp_path / "out",
        "--shared",
        "--json",
    )
    told = json.loads(eai("export", "harbor", "--domain", "virtualhome", *how).out)
    assert told == {"path": str(tmp_path / "out"), "tasks": 1, "left_out": {}}
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["virtualhome-goal_interpretation-27_2"]
