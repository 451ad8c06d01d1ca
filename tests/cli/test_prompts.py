from __future__ import annotations

import json
from pathlib import Path

from command_line import Command
from eai.abilities.protocol import Ability
from eai.base.store import DataPackStore
from suites import official_files

NAMED = ("--domain", "behavior", "--ability", "subgoal_decomposition")


def test_official_prompts_are_written_byte_for_byte(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    done = eai("export", "prompts", *NAMED, "--out", tmp_path / "new" / "prompts.json")
    files = official_files("behavior", Ability.SUBGOAL_DECOMPOSITION, data_store)
    assert done.status == 0
    assert (tmp_path / "new" / "prompts.json").read_bytes() == files.prompts
    assert (tmp_path / "new" / "prompts_system.json").read_bytes() == files.system
    assert str(tmp_path / "new" / "prompts_system.json") in done.out


def test_other_prompts_have_the_same_shape(eai: Command, data_store: DataPackStore, tmp_path: Path) -> None:
    (tmp_path / "action_sequencing.txt").write_text("Mine: $task")
    arguments = ("--domain", "behavior", "--ability", "action_sequencing", "--out", tmp_path / "p.json")
    assert eai("export", "prompts", *arguments, "--set", "eai", "--prompts", tmp_path).status == 0
    rows = json.loads((tmp_path / "p.json").read_text())
    assert len(rows) == 100
    assert all(row.keys() == {"identifier", "llm_prompt"} for row in rows)
    assert rows[0]["llm_prompt"].startswith("Mine: Task: ")
    assert not (tmp_path / "p_system.json").exists()


def test_a_folder_that_cannot_be_written_is_named(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    done = eai("export", "prompts", *NAMED, "--out", tmp_path / "file" / "p.json")
    assert done.status == 2
    assert "cannot be written" in done.err
    assert len(done.err.splitlines()) == 1


JARS = "bottling_fruit_0_Wainscott_0_int_0_2021-05-24_19-46-46"


def write_goals(folder: Path) -> None:
    """Write an answer with the goals of a task."""
    answer = '{"node goals": [["open", "jar.n.01_1"]], "edge goals": [["next_to", "jar.n.01_1", "sky"]]}'
    rows = [{"identifier": JARS, "llm_output": answer}]
    (folder / "some-model_outputs.json").write_text(json.dumps(rows))


def test_prompts_of_a_pipeline_state_the_goals_of_answers(
    eai: Command, data_store: DataPackStore, tmp_path: Path
) -> None:
    write_goals(tmp_path)
    done = eai("export", "prompts", *NAMED, "--goals", tmp_path, "--out", tmp_path / "p.json")
    assert done.status == 0
    (row,) = json.loads((tmp_path / "p.json").read_text())
    assert row["identifier"] == JARS
    assert "## Goal States\nopen(jar.0)\nnext.to(jar.0, sky)\n\n## Output" in row["llm_prompt"]
    again = ("--goals", tmp_path, "--out", tmp_path / "p.json")
    assert "is not a task of" in eai("export", "prompts", *NAMED, *again, "--tasks", "no_such").err
    other = ("--domain", "behavior", "--ability", "transition_modeling", "--out", tmp_path / "p.json")
    assert (
        "questions of transition_modeling state no goals; choose action_sequencing or subgoal_decomposition"
        in eai("export", "prompts", *other, "--goals", tmp_path).err
    )
