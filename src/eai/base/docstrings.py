"""Read the descriptions of options and fields from docstrings. This module does not need pydantic."""

from __future__ import annotations

import re
from inspect import cleandoc

_MEANING = re.compile(r"^    (\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)


def read_docstring_entries(docstring: str | None, heading: str) -> dict[str, str]:
    """Return a mapping from the names in a section of a docstring to their descriptions.

    A section is, for example, ``Attributes``. A description may continue on further, indented lines. In the
    result, spaces replace its line breaks.
    """
    _, _, section = cleandoc(docstring or "").partition(f"\n\n{heading}:\n")
    entries = _MEANING.findall(section.partition("\n\n")[0])
    return {name: " ".join(meaning.split()) for name, meaning in entries}
