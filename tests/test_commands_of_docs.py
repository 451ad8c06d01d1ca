"""Tests that the commands in README, docs and help exist, with valid options and values.

`tools/walk_docs.py` runs them.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from by_path import module_at
from eai.base.entry_points import get_entry_point_names, get_entry_points
from eai.cli import app

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
EXAMPLE = re.compile(r"Example: (eai .*?)(?:\n\n|\Z)", re.DOTALL)
REDIRECTED = {"|", ">", "||", "&&", ";"}
"""Shell symbols that end a command."""

VARIABLES = {
    "$SLURM_ARRAY_TASK_ID": "1",
    "$domain": "behavior",
    "$ability": "action_sequencing",
    "$name": "base",
    "$set": "eai",
}
"""Shell variables on pages, with example values."""


ABSENT = {*get_entry_point_names("eai.commands")}.difference(get_entry_points("eai.commands"))
"""Commands of extensions that `tools/without.py` removes."""


def walked(page: str) -> Iterator[str]:
    """Return the commands on a page, as `tools/walk_docs.py` finds them."""
    module = module_at("tools/walk_docs.py")
    yield from module.find_commands(page)


def invocations(line: str) -> Iterator[list[str]]:
    """Yield the arguments of each ``eai`` in a line of shell."""
    for name, value in VARIABLES.items():
        line = line.replace(name, value)
    lexer = shlex.shlex(line.replace("\n", ";"), posix=True, punctuation_chars="|>;&")
    lexer.commenters, lexer.whitespace_split = "#", True
    words, found = [*lexer, ";"], list[str]()
    for word in words:
        if word in REDIRECTED:
            if "eai" in found:
                arguments = found[found.index("eai") + 1 :]
                if not ABSENT.intersection((" ".join(arguments[:1]), " ".join(arguments[:2]))):
                    yield arguments
            found = []
        else:
            found.append(word)


def understand(arguments: list[str]) -> None:
    """Parse a command line without running it.

    Raises:
        ClickException: The command line is invalid.
    """
    command: Any = typer.main.get_command(app)
    context = None
    while True:
        try:
            context = command.make_context(command.name or "eai", list(arguments), parent=context)
        except typer.Exit:  # --version has answered
            return
        if not hasattr(command, "commands"):
            return
        rest = [*context._protected_args, *context.args]  # name and arguments of a subcommand
        if not rest:
            return
        _, command, arguments = command.resolve_command(context, rest)


def helped(command: Any) -> Iterator[str]:
    """Yield the examples in the help of a command and of its subcommands."""
    yield from (" ".join(each.split()) for each in EXAMPLE.findall(command.help or ""))
    for name in getattr(command, "commands", ()):
        yield from helped(command.commands[name])


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_commands_of_a_page_are_understood(page: Path) -> None:
    for line in walked(page.read_text("utf-8")):
        for arguments in invocations(line):
            try:
                understand(arguments)
            except Exception as error:
                pytest.fail(f"{line}: {error!r}")


def test_the_examples_of_help_are_understood() -> None:
    examples = list(helped(typer.main.get_command(app)))
    assert len(examples) >= 20
    for line in examples:
        for arguments in invocations(line):
            understand(arguments)


@pytest.mark.parametrize(
    "line", ["eai scroe a.json", "eai score a.json --domian virtualhome", "eai run --model m --epochs 0"]
)
def test_a_misspelt_command_line_is_refused(line: str) -> None:
    (arguments,) = invocations(line)
    with pytest.raises(Exception, match=r"No such|greater"):  # the class differs between versions of typer
        understand(arguments)
