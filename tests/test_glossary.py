"""The glossary has every public class, and they do not become more."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

TOOL = Path(__file__).parent.parent / "tools" / "glossary.py"
MOST = 512
"""How many public classes there may be: lower it where some go; 350 is the aim."""


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("glossary", TOOL)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_the_docstrings_say(tool: ModuleType) -> None:
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/glossary.py"


def test_every_public_class_says_what_it_is(tool: ModuleType) -> None:
    assert [each for each in tool.public_classes() if not each.meaning.endswith((".", ":"))] == []


def test_there_are_no_more_public_classes_than_there_were(tool: ModuleType) -> None:
    assert len(list(tool.public_classes())) <= MOST


def test_there_are_25_nouns(tool: ModuleType) -> None:
    assert len(tool.NOUNS) == 25
