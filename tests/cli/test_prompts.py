from __future__ import annotations

import json
from pathlib import Path

from cli.conftest import Command
from eai.abilities.protocol import Ability
from eai.data.store import Store
from suites import official_files

NAMED = ("--domain", "behavior", "--ability", "subgoal_decomposition")


def test_official_prompts_are_written_byte_for_byte(eai: Command, data_store: Store, tmp_path: Path) -> None:
    done = eai("prompts", *NAMED, "--out", tmp_path / "new" / "prompts.json")
    files = official_files("behavior", Ability.SUBGOAL_DECOMPOSITION, data_store)
    assert done.status == 0
    assert (tmp_path / "new" / "prompts.json").read_bytes() == files.prompts
    assert (tmp_path / "new" / "prompts_system.json").read_bytes() == files.system
    assert str(tmp_path / "new" / "prompts_system.json") in done.out


def test_other_prompts_have_the_same_shape(eai: Command, data_store: Store, tmp_path: Path) -> None:
    (tmp_path / "action_sequencing.txt").write_text("Mine: $task")
    arguments = ("--domain", "behavior", "--ability", "action_sequencing", "--out", tmp_path / "p.json")
    assert eai("prompts", *arguments, "--set", "eai", "--prompts", tmp_path).status == 0
    rows = json.loads((tmp_path / "p.json").read_text())
    assert len(rows) == 100
    assert all(row.keys() == {"identifier", "llm_prompt"} for row in rows)
    assert rows[0]["llm_prompt"].startswith("Mine: Task: ")
    assert not (tmp_path / "p_system.json").exists()


def test_a_folder_that_cannot_be_written_is_named(eai: Command, data_store: Store, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = eai("prompts", *NAMED, "--out", tmp_path / "file" / "p.json")
    assert done.status == 2
    assert "cannot be written" in done.err
    assert len(done.err.splitlines()) == 1
