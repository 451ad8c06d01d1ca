"""Tests that each tutorial runs as written, in an empty folder, and prints the shown output.

Blocks are followed in order: files to be saved or changed are written, and ``console`` commands run. The
output of a command must contain the ``text`` block after it. ``sh`` blocks are skipped, because they need
programs that a test does not have.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from by_path import module_at
from processes import eai
from run.server import Reply, serve
from sweeps import sweep

ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "docs/tutorials").glob("*.md"))
BLOCK = re.compile(
    r"(?:`(?P<file>[\w.]+)`:\n\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
QUICK = ("domain", "score")
"""Tutorials of the default set; the others ask models about households."""

SERVER = "http://localhost:8000/v1"
"""Address of the model server in the tutorials."""


class Block(NamedTuple):
    """A fenced block, with the file that the text before it names."""

    language: str
    text: str
    file: str | None


def blocks(page: str) -> Iterator[Block]:
    """Return the fenced blocks of a page, in order."""
    return (Block(match["language"], match["text"], match["file"]) for match in BLOCK.finditer(page))


def changed(source: str, change: str) -> str:
    """Return a text after a change in the form of a diff, whose hunks are found by their lines."""
    for part in change.split("@@\n"):
        lines = [(line[0], line[1:]) for line in part.splitlines(keepends=True)]
        old = "".join(text for sign, text in lines if sign in " -")
        new = "".join(text for sign, text in lines if sign in " +")
        assert source.count(old) == 1, old
        source = source.replace(old, new)
    return source


def bare(text: str) -> str:
    """Return a text without blanks at the ends of lines."""
    return "\n".join(line.rstrip() for line in text.splitlines())


def carry_out(page: Path, monkeypatch: pytest.MonkeyPatch, server: str) -> int:
    """Follow a tutorial, and return the number of compared outputs."""
    printed, compared = "", 0
    for block in blocks(page.read_text("utf-8")):
        if block.language == "diff" and block.file:
            file = Path(block.file)
            file.write_text(changed(file.read_text("utf-8"), block.text), "utf-8")
        elif block.file:
            Path(block.file).write_text(block.text, "utf-8")
        elif block.language == "console":
            printed = "".join(done(line, monkeypatch, server) for line in commands(block.text))
        elif block.language == "python":
            printed = ""  # test_readme.py compares the output of such a block
        elif block.language == "text" and printed:
            assert bare(block.text) in bare(printed), printed
            compared += 1
    return compared


def commands(text: str) -> list[list[str]]:
    return [shlex.split(line.removeprefix("$ ")) for line in text.splitlines()]


def done(command: list[str], monkeypatch: pytest.MonkeyPatch, server: str) -> str:
    """Run one command of a page, and return its output."""
    program, *words = command
    if program == "cd":
        monkeypatch.chdir(words[0])
        return ""
    if program == "pip":
        return ""
    if program == "python":
        return subprocess.run([sys.executable, *words], check=True, capture_output=True, text=True).stdout
    assert program == "eai"
    outcome = eai(*(server if word == SERVER else word for word in words), columns=80)
    assert outcome.status == 0, outcome.err
    return outcome.out


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=() if page.stem in QUICK else sweep) for page in PAGES],
    ids=lambda page: page.stem,
)
def test_a_tutorial_runs_as_it_is_written(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with serve(defaultdict(lambda: [Reply("{}")])) as server:
        compared = carry_out(page, monkeypatch, server.url)
    assert compared or page.stem == "train"


def test_there_are_five() -> None:
    assert [page.stem for page in PAGES] == ["act", "domain", "run", "score", "train"]


def test_the_notebook_is_the_page() -> None:
    written = module_at("tools/notebook.py").make_notebook(
        (ROOT / "docs/tutorials/train.md").read_text("utf-8")
    )
    assert (ROOT / "docs/tutorials/train.ipynb").read_text("utf-8") == written, "python tools/notebook.py"


def test_a_change_that_does_not_fit_fails() -> None:
    assert changed("a\nb\nc\n", " a\n-b\n+d\n@@\n-c\n") == "a\nd\n"
    with pytest.raises(AssertionError):
        changed("a\nb\n", "-c\n+d\n")
