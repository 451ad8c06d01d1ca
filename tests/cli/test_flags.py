"""The flags of ``eai run`` and the options that `--with` sets."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer

from by_path import ROOT
from command_line import Command
from eai.base.store import DataPackStore
from eai.cli import app
from eai.run.spec import get_default_text_by_option
from processes import eai as run_eai

PAGE = ROOT / "docs" / "run-options.md"


def test_the_flags_are_few() -> None:
    group: object = typer.main.get_command(app)
    command = group.commands["run"]  # type: ignore[attr-defined]
    options = [each for each in command.params if each.param_type_name == "option"]
    assert len(options) <= 25


def test_all_options_are_listed_where_the_documentation_has_them(eai: Command) -> None:
    listed = eai("run", "--with", "help")
    assert listed.status == 0
    assert all(f"| `{key}` |" in listed.out for key in get_default_text_by_option())
    assert "|  |\n" not in listed.out, "each has a meaning"
    assert listed.out in PAGE.read_text(encoding="utf-8"), "put the output of eai run --with help there"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("replans=3", "--with replans=3: expected SECTION.OPTION=VALUE; did you mean replanning.replans?"),
        ("replanning.replans", "--with replanning.replans: expected SECTION.OPTION=VALUE"),
        (
            "replanning.replan=3",
            "replanning.replan: unknown; did you mean replans? (replanning has replans, world, ",
        ),
        ("replanning.replans=x", "replanning.replans: expected a whole number, found 'x'"),
        ("replanning.replans.x=1", "replanning.replans: expected "),
    ],
)
def test_a_setting_that_is_none_is_refused(setting: str, message: str, eai: Command, tmp_path: Path) -> None:
    done = eai("run", "--model", "eai/oracle", "--with", setting, "--out", tmp_path)
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert done.err.startswith(f"eai: {message}")


def test_a_run_is_repeated_from_its_file(data_store: DataPackStore, tmp_path: Path) -> None:
    """No question is asked again. Flags replace values of the file, and another run gets another file."""
    named = (
        "--model",
        "eai/noisy",
        "-M",
        "rate=0.3",
        "--domain",
        "behavior",
        "--ability",
        "action_sequencing",
    )
    out = ("--out", tmp_path, "--json")
    first = run_eai("run", *named, "--limit", 2, "--with", "replanning.replans=1", *out)
    assert first.status == 0, first.err
    file, (journal,) = tmp_path / "run.toml", tmp_path.glob("**/answers.jsonl")
    before = journal.read_bytes()
    assert run_eai("run", file, *out).out == first.out
    assert journal.read_bytes() == before
    assert len([*(tmp_path / "logs").iterdir()]) == 1
    fewer = run_eai("run", file, "--limit", 1, "--with", "replanning.replans=0", *out)
    (result,) = json.loads(fewer.out)
    assert (result["answered"], Path(result["folder"]).name) == (1, "eai_noisy")
    assert sorted(each.name for each in tmp_path.glob("*.toml")) == ["run-2.toml", "run.toml"]


def test_a_mistake_in_a_file_of_options_is_told_with_the_file(eai: Command, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[task]\nlimit = 2\n")
    done = eai("run", file, "--out", tmp_path)
    assert done.err.startswith(f"eai: {file}: task: unknown; did you mean tasks?")
    file.write_text("[tasks]\nlimit = 0\n")
    done = eai("run", file, "--limit", "1", "--with", "generation.topp=1", "--out", tmp_path)
    assert done.err.startswith("eai: generation.topp: unknown; did you mean top_p?"), "flags replace the file"


def test_somebody_has_to_be_asked(eai: Command, tmp_path: Path) -> None:
    done = eai("run", "--limit", "1", "--out", tmp_path)
    assert (done.status, done.err) == (
        2,
        "eai: expected --model NAME, or a FILE.toml with names of models in model.name\n",
    )
