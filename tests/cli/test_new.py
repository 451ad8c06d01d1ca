"""`eai new` writes a domain that `eai check` finds nothing wrong with."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import Command


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
        ("json", "json: expected another name; Python has a module of this one"),
        ("old", "old: expected a new folder; this one is there already"),
    ],
)
def test_a_name_that_no_module_can_have_is_refused(
    eai: Command, here: Path, name: str, expected: str
) -> None:
    (here / "old").mkdir()
    assert eai("new", name) == (2, "", f"eai: {expected}\n")
    assert [*here.iterdir()] == [here / "old"]
