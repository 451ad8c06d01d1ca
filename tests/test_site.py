"""Tests that pages of the site equal the repository's, except for marks that only the latter understands."""

from __future__ import annotations

from pathlib import Path

from by_path import module_at

SITE = module_at("tools/site.py")


def test_a_link_to_a_folder_becomes_its_name(tmp_path: Path) -> None:
    (tmp_path / "results").mkdir()
    (tmp_path / "page.md").touch()
    page = "[the results](results), [a page](page.md#part) and [a site](https://example.org/)"
    assert (
        SITE.adapt_links(page, tmp_path)
        == "the results, [a page](page.md#part) and [a site](https://example.org/)"
    )


def test_bars_in_the_code_of_a_table_lose_their_backslash(tmp_path: Path) -> None:
    assert (
        SITE.adapt_links(r"| `--kind <a\|b>` | one \| two |", tmp_path) == r"| `--kind <a|b>` | one \| two |"
    )


def test_the_navigation_has_the_pages_that_the_index_lists_below_each_heading(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    index = (
        "# Pages\n\n## Look up\n\n| page | content |\n|---|---|\n| [Options of `run`](run.md) | options |\n"
    )
    (tmp_path / "docs/README.md").write_text(index, encoding="utf-8")
    assert SITE.make_navigation(tmp_path)[2:] == [{"Look up": [{"Options of run": "docs/run.md"}]}]
