"""Tests that the modules, classes and functions that the documentation names exist."""

from __future__ import annotations

import re
from importlib.metadata import entry_points
from pathlib import Path
from pkgutil import resolve_name

import pytest

ROOT = Path(__file__).parent.parent
NAME = re.compile(r"\beai(?:\.[A-Za-z_]\w*)+")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NAMED = sorted({name for page in PAGES for name in NAME.findall(page.read_text(encoding="utf-8"))})


def test_the_documentation_names_many_parts_of_the_package() -> None:
    assert len(NAMED) > 50


@pytest.mark.parametrize("name", NAMED)
def test_what_the_documentation_names_exists(name: str) -> None:
    if ".ray_scoring" in name:
        pytest.importorskip("ray", reason="Ray is not installed")
    if name not in entry_points().groups:
        resolve_name(name)
