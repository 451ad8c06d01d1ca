from __future__ import annotations

from pathlib import Path

import pytest

from command_line import Command
from eai.base.store import DataPackStore
from eai.cli import demo
from processes import eai as in_own_process


def test_it_says_at_once_what_it_does_and_ends_with_what_to_do_next(
    eai: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ran: list[str] = []
    monkeypatch.setattr(demo, "_print_and_run_command", ran.append)
    done = eai("demo", "--out", tmp_path / "my demo")
    assert done.status == 0
    assert done.out.startswith("Two built-in models, of which one makes mistakes, do 40 tasks")
    assert [command.split()[0] for command in ran] == ["run", "explain"]
    assert all(f"'{tmp_path}/my demo" in command for command in ran)
    assert done.out.split("To go on:\n")[1].count("  eai ") == 3


def test_a_command_that_ends_with_an_error_ends_the_demo(
    eai: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, data_store: DataPackStore
) -> None:
    monkeypatch.setattr(demo, "_EXPLAINED", "nowhere 616_1")
    monkeypatch.setattr(demo, "_TASKS", "none")
    done = eai("demo", "--out", tmp_path)
    assert (done.status, "To go on" in done.out) == (2, False)
    assert "--limit" in done.err


def test_its_results_are_not_among_those_of_eai_run(eai: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise `eai report runs` would find two runs of eai/noisy, and refuse them."""
    ran: list[str] = []
    monkeypatch.setattr(demo, "_print_and_run_command", ran.append)
    assert eai("demo").status == 0
    assert " --out demo" in ran[0]


@pytest.mark.sweep
def test_it_explains_an_answer_that_failed(data_store: DataPackStore, tmp_path: Path) -> None:
    done = in_own_process("demo", "--out", tmp_path / "demo")
    assert done.status == 0, done.err
    explained = done.out.split("Why an answer failed:")[1]
    assert "616_1" in explained
    assert "missing_step" in explained or "additional_step" in explained
