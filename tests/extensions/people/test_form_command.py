from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.test_json import FOLDER, PLAN
from cli.test_prompts import NAMED, write_goals
from command_line import Command
from eai.base.store import DataPackStore


def test_a_page_states_the_goals_of_answers(eai: Command, data_store: DataPackStore, tmp_path: Path) -> None:
    write_goals(tmp_path)
    done = eai("export", "prompts", *NAMED, "--goals", tmp_path, "--out", tmp_path / "p.html")
    assert "1 question;" in done.out
    assert "<section" in (tmp_path / "p.html").read_text(encoding="utf-8")


def test_no_page_pretends_that_people_can_act_on_it(eai: Command, tmp_path: Path) -> None:
    options = ("--domain", "agents.switches:SWITCHES", "--ability", "acting", "--out", tmp_path / "form.html")
    assert eai("export", "prompts", *options).err.endswith(
        "a page without a server cannot execute actions; use eai play --page\n"
    )
    assert not (tmp_path / "form.html").exists()


def test_what_is_written_is_told(eai: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(FOLDER)
    outcome = eai("export", "prompts", *PLAN, "--out", "f.html", "--json")
    assert json.loads(outcome.out).items() >= {"file": "f.html", "questions": 2}.items()
