"""Documentation stays short: README has at most 700 words, a page 1,500, and all pages what they have now."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parent.parent


def words(page: str) -> int:
    return len((ROOT / page).read_text(encoding="utf-8").split())


def test_readme_is_read_in_three_minutes() -> None:
    assert words("README.md") <= 700
