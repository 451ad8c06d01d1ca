"""Tests that the page of commands equals the help, and that the help describes each option."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import eai.cli
from by_path import module_at
from eai.base.docstrings import read_docstring_entries

TOOL = module_at("tools/commands_page.py")
MODULES = sorted(Path(eai.cli.__file__).parent.glob("*.py"), key=lambda path: path.name)


def test_the_page_is_what_the_help_says() -> None:
    assert TOOL.PAGE.read_text(encoding="utf-8") == TOOL.make_page(), "run: python tools/commands_page.py"


def test_every_option_has_a_meaning() -> None:
    rows = re.findall(r"^\| `([^`]+)` \| (.*)\|$", TOOL.make_page(), re.MULTILINE)
    assert len(rows) > 100
    assert [option for option, meaning in rows if not meaning.strip()] == []


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_a_docstring_tells_of_options_that_there_are(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            taken = {each.arg for each in (*node.args.args, *node.args.kwonlyargs)}
            assert read_docstring_entries(ast.get_docstring(node), "Options").keys() <= taken, node.name
