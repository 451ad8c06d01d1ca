"""The page of commands says what the help says."""

from __future__ import annotations

import importlib.util
from pathlib import Path

TOOL = Path(__file__).parent.parent / "tools" / "commands_page.py"


def test_the_page_is_what_the_help_says() -> None:
    spec = importlib.util.spec_from_file_location("commands_page", TOOL)
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/commands_page.py"
