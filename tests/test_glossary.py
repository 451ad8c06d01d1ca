"""Tests that the glossary explains the project's nouns, and that public classes are few and documented."""

from __future__ import annotations

from types import ModuleType

import pytest

from by_path import module_at

MAX_PUBLIC_CLASSES = 450
"""Maximum number of public classes. Lower it when classes go."""


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    return module_at("tools/glossary.py")


def test_the_page_is_up_to_date(tool: ModuleType) -> None:
    assert tool.PAGE.read_text(encoding="utf-8") == tool.make_page(), "run: python tools/glossary.py"


def test_every_public_class_has_a_docstring(tool: ModuleType) -> None:
    classes = tool.list_public_classes()
    assert [public for public in classes if not public.meaning.endswith((".", ":"))] == []


def test_there_are_no_more_public_classes_than_there_were(tool: ModuleType) -> None:
    assert len(list(tool.list_public_classes())) <= MAX_PUBLIC_CLASSES


def test_there_are_25_nouns(tool: ModuleType) -> None:
    assert len(tool.NOUNS) == 25
