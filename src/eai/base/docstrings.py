"""Descriptions of options and fields, read from docstrings without pydantic."""

from __future__ import annotations

import re
from inspect import cleandoc

_MEANING = re.compile(r"^    (\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def read_meanings(docstring: str | None, heading: str) -> dict[str, str]:
    """Return the descriptions in a section of a docstring, such as ``Attributes``, by name.

    The further lines of a description are indented. Line breaks become spaces.
    """
    _, _, section = cleandoc(docstring or "").partition(f"\n\n{heading}:\n")
    entries = _MEANING.findall(section.partition("\n\n")[0])
    return {name: " ".join(meaning.split()) for name, meaning in entries}
