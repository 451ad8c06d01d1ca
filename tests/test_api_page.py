"""The API page says what the docstrings say."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from eai.logic import formula

TOOL = Path(__file__).parent.parent / "tools" / "api_page.py"


@pytest.mark.skipif(not formula.__file__.endswith(".py"), reason="compiled classes have no docstrings")
def test_the_page_is_what_the_docstrings_say() -> None:
    spec = importlib.util.spec_from_file_location("api_page", TOOL)
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/api_page.py"
