"""Docstrings as data: the meanings that they tell of options and of members of files, without pydantic."""

from __future__ import annotations

import re
from inspect import cleandoc

_MEANING = re.compile(r"^    (\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def read_meanings(docstring: str | None, heading: str) -> dict[str, str]:
    """The meanings that a section of a docstring tells, by name; a long one goes on in indented lines."""
    _, _, section = cleandoc(docstring or "").partition(f"\n\n{heading}:\n")
    found = _MEANING.findall(section.partition("\n\n")[0])
    return {name: " ".join(meaning.split()) for name, meaning in found}
