"""Documentation stays short: README, each page, and all pages together have at most so many words."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TABLE = re.compile(
    r"^<!-- (?:errata: tools/errata_page\.py|written by: eai run --with help) -->$.*?^<!-- end -->$",
    re.MULTILINE | re.DOTALL,
)
"""A table on a page that a program writes, and a test compares."""

REFERENCE = {
    "api": "written by tools/api_page.py",
    "commands": "written by tools/commands_page.py",
    "errata": "an entry for each erratum",
    "glossary": "written by tools/glossary.py",
    "protocols": "an entry for each difference",
    "records": "an entry for each field",
    "study": "written by tools/study",
}
"""The pages that are looked things up in: they may be long."""

WRITTEN = ("api", "commands", "glossary", "study")
"""The pages that a program writes: their words are those of the code and its data."""


def words(page: Path) -> int:
    """How many words of a page are written by hand: the bars and rules of a table are none."""
    return len(re.findall(r"\S*\w\S*", TABLE.sub("", page.read_text(encoding="utf-8"))))


def test_readme_has_at_most_700_words() -> None:
    assert words(ROOT / "README.md") <= 700


@pytest.mark.parametrize(
    "page",
    [page for page in sorted((ROOT / "docs").rglob("*.md")) if page.stem not in REFERENCE],
    ids=lambda page: page.stem,
)
def test_a_page_has_at_most_1500_words(page: Path) -> None:
    assert words(page) <= 1500


def test_all_written_by_hand_has_at_most_30_000_words() -> None:
    pages = [page for page in (ROOT / "docs").rglob("*.md") if page.stem not in WRITTEN]
    assert sum(map(words, pages)) <= 30_000
