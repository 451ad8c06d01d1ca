"""The API page says what the docstrings say."""

from __future__ import annotations

import pytest

from by_path import module_at
from eai.logic import formula


@pytest.mark.skipif(not formula.__file__.endswith(".py"), reason="compiled classes have no docstrings")
def test_the_page_is_what_the_docstrings_say() -> None:
    tool = module_at("tools/api_page.py")
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/api_page.py"
