"""``--json``: every command that prints results takes it, and prints JSON and nothing else."""

from __future__ import annotations

import inspect
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from by_path import ROOT
from command_line import Command
from eai.base.store import DataPackStore
from eai.cli import app

FOLDER = ROOT / "examples" / "lamps"
WITHOUT = {"demo", "serve mcp"}
"""Conversations; extensions may have more."""

PLAN = ("--domain", "lamps:lamps", "--ability", "action_sequencing")
MADE: dict[tuple[str, ...], dict[str, Any]] = {
    ("export", "prompts", *PLAN, "--out", "p.json"): {"files": ["p.json"]},
    ("export", "tasks", *PLAN[:2], "--out", "t.jsonl"): {"file": "t.jsonl", "tasks": 2},
    ("export", "prompts", *PLAN, "--out", "r.jsonl"): {"path": "r.jsonl", "rows": 2, "left_out": {}},
    ("generate", "--like", "lamps:lamps", "--n", "1", "--out", "new"): {
        "file": "new/tasks.jsonl",
        "tasks": 1,
    },
}
"""Commands that write files -> what they say of them, at least."""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(FOLDER / "lamps.py", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)


def commands(group: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Any]]:
    for name in getattr(group, "commands", ()):
        yield from commands(group.commands[name], (*path, name))
    if not hasattr(group, "commands"):
        yield " ".join(path), group


def is_of_core(command: Any) -> bool:
    return getattr(inspect.unwrap(command.callback), "__module__", "").startswith("eai.cli.")


def test_every_command_takes_it() -> None:
    found = {name: one for name, one in commands(typer.main.get_command(app)) if is_of_core(one)}
    takes = {name for name, one in found.items() if "--json" in [o for p in one.params for o in p.opts]}
    missing = {name for name in found.keys() - takes if not name.startswith("analyze ")}
    assert missing == WITHOUT


@pytest.mark.parametrize("arguments", MADE, ids=" ".join)
def test_what_is_written_is_told(arguments: tuple[str, ...], eai: Command) -> None:
    outcome = eai(*arguments, "--json")
    assert outcome.status == 0, outcome.err
    assert MADE[arguments].items() <= json.loads(outcome.out).items()


def test_the_data_set_that_is_there_is_told(eai: Command, data_store: DataPackStore) -> None:
    told = json.loads(eai("data", "fetch", "--data", data_store.folder, "--json").out)
    assert told == {"folder": str(data_store.folder), "made": []}


def test_shards_put_together_are_told_as_what_is_scored_at_once(eai: Command) -> None:
    answers = [{"identifier": "light", "llm_output": '[{"action": "GO", "object": "lamp_1"}]'}]
    Path("m_outputs.json").write_text(json.dumps(answers))
    whole = json.loads(eai("score", "m_outputs.json", *PLAN, "--out", "whole", "--json").out)
    for shard in ("1/2", "2/2"):
        eai("score", "m_outputs.json", *PLAN, "--shard", shard, "--out", "parts")
    merged = json.loads(eai("score", "parts", "--merge", "--json").out)
    assert [{**one, "folder": None} for one in merged] == [{**one, "folder": None} for one in whole]
