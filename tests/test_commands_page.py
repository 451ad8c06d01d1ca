"""The page of commands says what the help says."""

from __future__ import annotations

from by_path import module_at


def test_the_page_is_what_the_help_says() -> None:
    tool = module_at("tools/commands_page.py")
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/commands_page.py"
