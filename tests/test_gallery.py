"""Tests that pages show each picture in docs/images/gallery once, drawn by a program, and small."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

from by_path import module_at

MAX_BYTES = 100_000
"""Maximum size of a picture."""

PICTURE = re.compile(r"!\[[^\]]+\]\([^)]*images/gallery/(?P<name>\w+)\.png\)")


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    pytest.importorskip("PIL")
    return module_at("tools/gallery.py")


def test_pages_show_each_figure_once(gallery: ModuleType) -> None:
    pages = Path(gallery.ROOT, "docs").rglob("*.md")
    names = [match["name"] for page in pages for match in PICTURE.finditer(page.read_text(encoding="utf-8"))]
    assert Counter(names) == Counter(figure.name for figure in gallery.FIGURES)


def test_each_picture_is_drawn_by_the_program_and_small(gallery: ModuleType) -> None:
    pictures = {path.stem: path.stat().st_size for path in gallery.PICTURES.glob("*.png")}
    assert sorted(pictures) == sorted(figure.name for figure in gallery.FIGURES)
    assert max(pictures.values()) < MAX_BYTES
