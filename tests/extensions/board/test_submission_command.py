from __future__ import annotations

import json
from pathlib import Path

from command_line import Command
from eai.abilities.protocol import PAPER_ABILITIES
from eai.base.store import DataPackStore


def test_an_incomplete_run_is_built_and_its_gaps_are_named(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    place = tmp_path / "run" / "behavior" / "action_sequencing" / "gpt"
    place.mkdir(parents=True)
    task_id = "assembling_gift_baskets_0_Beechwood_0_int_0_2021-10-26_12-46-37"
    answers = [{"identifier": task_id, "llm_output": "[]"}]
    (place / "gpt_outputs.json").write_text(json.dumps(answers))
    archive = tmp_path / "submission.zip"
    built = eai("export", "submission", tmp_path / "run", "--out", archive)
    assert built.status == 2
    assert f"written to {archive}" in built.out
    lines = built.out.splitlines()
    assert len(lines) == 1 + (2 * len(PAPER_ABILITIES) - 1) + 6
    assert "behavior_action_sequencing_outputs.json: and 94 more (--json lists all)" in lines
    assert "virtualhome_goal_interpretation_outputs.json: is missing" in lines
    assert sum(line.startswith("behavior_action_sequencing_outputs.json: ") for line in lines) == 6
    assert not any(task_id in line for line in lines)
    checked = eai("export", "submission", archive)
    assert (checked.status, checked.out.splitlines()) == (2, lines[1:])


def test_an_invalid_submission_is_reported_in_one_line(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    for arguments in (
        ("export", "submission", tmp_path / "none.zip"),
        ("export", "submission", tmp_path / "none", "--out", tmp_path / "s.zip"),
    ):
        done = eai(*arguments)
        assert done.status == 2
        assert len(done.err.splitlines()) == 1
