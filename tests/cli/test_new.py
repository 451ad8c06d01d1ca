"""`eai new` writes a domain that `eai check` finds nothing wrong with."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from command_line import Command
from processes import eai as in_own_process


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_new_domain_is_checked_and_run(eai: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    made = eai("new", "depot")
    assert made.out == "depot/depot.py, depot/README.md written\nnext: cd depot; eai check depot:depot\n"
    monkeypatch.chdir("depot")
    assert eai("check", "depot:depot").out == (
        "depot: 3 operators and 2 tasks; nothing is wrong; the planner solves 2 of the 2 without a plan\n"
    )
    assert "NAME" not in Path("depot.py").read_text() + Path("README.md").read_text()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("my-world", "my-world: expected a name in Python: letters, digits and underscores"),
        ("class", "class: expected a name in Python: letters, digits and underscores"),
        ("json", "json: expected another name; a Python module has this name"),
        ("old", "old: expected a new folder; this one is there already"),
    ],
)
def test_a_name_that_no_module_can_have_is_refused(
    eai: Command, here: Path, name: str, expected: str
) -> None:
    (here / "old").mkdir()
    assert eai("new", name) == (2, "", f"eai: {expected}\n")
    assert [*here.iterdir()] == [here / "old"]


def test_the_names_of_built_in_models_are_the_same_in_options_and_records(
    eai: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    eai("new", "yard")
    monkeypatch.chdir("yard")
    run = ("run", "--model", "eai/noisy", "--ability", "action_sequencing", "--domain", "yard:yard")
    assert in_own_process(*run, "--out", "runs", "--quiet").status == 0
    (file,) = Path("runs").rglob("records.jsonl")
    assert {json.loads(line)["model"] for line in file.read_text().splitlines()} == {"eai/noisy"}
    listed = eai("explain", "runs", "--model", "eai/noisy").out
    assert eai("explain", "runs", "--model", "eai_noisy").out == listed
    assert listed.count("fetch") == listed.count("gather") == 1
    scored = eai("score", "runs", "--domain", "yard:yard", "--ability", "action_sequencing", "--out", "new")
    assert scored.status == 0
    assert "model eai/noisy" in eai("explain", "new", "fetch").out
