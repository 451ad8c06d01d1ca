"""Read the descriptions of options and fields from docstrings, without pydantic."""

from __future__ import annotations

import re
from inspect import cleandoc

_MEANING = re.compile(r"^    (\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def read_docstring_entries(docstring: str | None, heading: str) -> dict[str, str]:
    """Return a mapping from names to descriptions in a section of a docstring, such as ``Attributes``.

    In the docstring, the further lines of a description are indented. In the texts, line breaks are spaces.
    """
    _, _, section = cleandoc(docstring or "").partition(f"\n\n{heading}:\n")
    entries = _MEANING.findall(section.partition("\n\n")[0])
    return {name: " ".join(meaning.split()) for name, meaning in entries}
