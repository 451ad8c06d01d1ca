"""Write docs/commands.md from the help of all commands: `python tools/commands_page.py`.

No plugin of MkDocs does this: with Typer 0.29, mkdocs-typer2 0.4.1 and mkdocs-click 0.9.0 show no option of
a command that an entry point loads. With a plugin, the page in the repository would also be empty.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from eai.cli import app

PAGE = Path(__file__).resolve().parents[1] / "docs" / "commands.md"
HEAD = """\
# Commands

On this page you can look up every command of `eai` and its options. [Options of a run](run-options.md) has
those that `eai run` takes by `--with`. `python tools/commands_page.py` writes this page from the help.
"""
EXAMPLE = re.compile(r"(Example|Start): (eai .*?)(?: +(\(.*\)))?$")
MARKDOWN = re.compile(r"([<>*_|])")
"""Characters of help texts that have a meaning in Markdown."""


def make_page() -> str:
    """Return the page."""
    return HEAD + "".join(_make_sections(typer.main.get_command(app), "eai"))


def _make_sections(command: Any, name: str) -> Iterator[str]:
    """Yield the section of a command, then the sections of its subcommands."""
    context = command.context_class(command, info_name=name)
    parameters = [parameter for parameter in command.params if not parameter.hidden]
    arguments = [parameter.metavar for parameter in parameters if parameter.param_type_name == "argument"]
    yield f"\n## {name}\n\n`{' '.join([name, *arguments, '[OPTIONS]'])}`\n"
    yield from (f"\n{_format_paragraph(text)}\n" for text in command.help.split("\n\n"))
    if parameters:
        yield "\n| option | meaning |\n|---|---|\n"
        yield from (_row(*parameter.get_help_record(context)) for parameter in parameters)
    for below in getattr(command, "commands", ()):
        yield from _make_sections(command.commands[below], f"{name} {below}")


def _row(option: str, meaning: str) -> str:
    option, meaning = option.replace("|", r"\|"), MARKDOWN.sub(r"\\\1", " ".join(meaning.split()))
    return f"| `{option}` | {meaning} |\n"


def _format_paragraph(text: str) -> str:
    """Return a paragraph of help as Markdown, with examples as code."""
    example = EXAMPLE.match(text)
    if example is None:
        return MARKDOWN.sub(r"\\\1", text)
    label, command, remark = example.groups(default="")
    return f"{label}: `{command}` {remark}".rstrip()


if __name__ == "__main__":
    PAGE.write_text(make_page(), encoding="utf-8")
