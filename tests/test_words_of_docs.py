"""Tests that documentation stays short: README, the changelog, each page, and all pages together."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
WRITTEN_PART = re.compile(
    r"^<!-- (?:errata: tools/errata_page\.py|prompt lengths: tools/prompt_lengths\.py"
    r"|written by: eai run --with help) -->$.*?^<!-- end -->$"
    r"|^::: \S+$",
    re.MULTILINE | re.DOTALL,
)
"""Pattern of a table that a program writes, or of an object whose docstring the site shows."""

EXTENSIONS = ROOT / "src/eai/extensions"

REFERENCE = {
    "commands": "written by tools/commands_page.py",
    "errata": "an entry for each erratum",
    "extensions/reference/README": "an entry for each difference",
    "glossary": "written by tools/glossary.py",
    "protocols": "an entry for each rule",
    "records": "an entry for each field",
    "study": "written by tools/study",
}
"""Pages for reference, which may be long."""

WRITTEN = ("commands", "glossary", "study")
"""Pages that a program writes from the code and its data."""


def name_of(page: Path) -> str:
    """Return the path of a page below docs/, without its ending."""
    return page.relative_to(ROOT / "docs").with_suffix("").as_posix()


def words(page: Path) -> int:
    """Return the number of words that are written by hand, without the rules of tables."""
    return len(re.findall(r"\S*\w\S*", WRITTEN_PART.sub("", page.read_text(encoding="utf-8"))))


def test_readme_has_at_most_700_words() -> None:
    assert words(ROOT / "README.md") <= 700


@pytest.mark.parametrize(
    "page",
    [page for page in sorted((ROOT / "docs").rglob("*.md")) if name_of(page) not in REFERENCE],
    ids=name_of,
)
def test_a_page_has_at_most_1500_words(page: Path) -> None:
    assert words(page) <= 1500


def test_all_written_by_hand_has_at_most_30_000_words() -> None:
    pages = [page for page in (ROOT / "docs").rglob("*.md") if name_of(page) not in WRITTEN]
    assert sum(map(words, pages)) <= 30_000


def test_each_extension_has_a_page_that_begins_with_its_purpose_and_how_to_install_it() -> None:
    names = sorted(path.parent.name for path in EXTENSIONS.glob("*/__init__.py"))
    assert sorted(page.parent.name for page in (ROOT / "docs/extensions").glob("*/README.md")) == names
    for name in names:
        head, *_ = (ROOT / "docs/extensions" / name / "README.md").read_text("utf-8").split("\n## ")
        assert "\n\nThis extension " in head, name
        assert "It comes with `eai`" in head or "$ pip install" in head, name


def test_the_changelog_has_at_most_1500_words_until_there_is_a_release() -> None:
    page = ROOT / "CHANGELOG.md"
    versions = re.findall(r"^## \[(.+)\]$", page.read_text("utf-8"), re.MULTILINE)
    assert versions[0] == "Unreleased"
    assert len(versions) > 1 or words(page) <= 1500
