"""The gallery is what its script writes, and small."""

from __future__ import annotations

from types import ModuleType

import pytest

from by_path import module_at

LARGEST = 100_000
"""Bytes of a picture."""


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    pytest.importorskip("PIL")
    return module_at("tools/gallery.py")


def test_the_page_shows_every_figure(gallery: ModuleType) -> None:
    assert gallery.PAGE.read_text(encoding="utf-8") == gallery.page(gallery.FIGURES)
    pictures = {path.stem: path.stat().st_size for path in gallery.PICTURES.glob("*.png")}
    assert sorted(pictures) == sorted(each.name for each in gallery.FIGURES)
    assert max(pictures.values()) < LARGEST
