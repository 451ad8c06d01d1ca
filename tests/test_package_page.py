"""README as a package page has it: nothing in it leads to files of the repository, which are not there."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from test_readme import LINK

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parent.parent


@pytest.fixture
def page() -> str:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for each in settings["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["substitutions"]:
        text = re.sub(each["pattern"], each["replacement"], text)
    return text


def test_no_link_is_relative(page: str) -> None:
    assert LINK.search((ROOT / "README.md").read_text(encoding="utf-8"))
    assert LINK.findall(page) == []


def test_what_is_not_a_relative_link_stays(page: str) -> None:
    assert "[Inspect](https://inspect.aisi.org.uk)" in page
    assert "The public names." in page
    assert "![" not in page
