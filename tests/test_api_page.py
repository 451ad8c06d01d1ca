"""Tests that the page of public names has each name once, to which the site adds signature and docstring."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

import eai
import eai.world

PAGE = Path(__file__).parent.parent / "docs" / "api.md"
DIRECTIVE = re.compile(r"^::: (?P<name>\S+)$", re.MULTILINE)


def listed_names() -> Counter[str]:
    return Counter(match["name"] for match in DIRECTIVE.finditer(PAGE.read_text(encoding="utf-8")))


@pytest.mark.parametrize("module", [eai, eai.world], ids=lambda module: module.__name__)
def test_the_page_lists_each_public_name_once(module: ModuleType) -> None:
    prefix = module.__name__
    names = {name: count for name, count in listed_names().items() if name.rpartition(".")[0] == prefix}
    assert names == dict.fromkeys((f"{prefix}.{name}" for name in module.__all__), 1)


def test_the_page_lists_nothing_else() -> None:
    assert {name.rpartition(".")[0] for name in listed_names()} == {"eai", "eai.world"}
