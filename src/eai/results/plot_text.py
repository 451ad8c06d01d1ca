"""Names as labels of plots."""

from __future__ import annotations

import textwrap

_LONGEST = 30
_MOST_LINES = 3
_LAST_LETTER = "\u058f"
"""The plots' font has the letters up to here (Latin, Greek, Cyrillic, Armenian)."""


def wrapped(name: str) -> str:
    """A name as a label of up to three lines, so that a check's can be read in full."""
    text = "".join(c if c.isprintable() and c <= _LAST_LETTER else "?" for c in name)
    return textwrap.fill(text, _LONGEST, max_lines=_MOST_LINES, placeholder="...")


def clipped(name: str) -> str:
    """A name as a label: one short line of characters that the plots' font has."""
    text = "".join(c if c.isprintable() and c <= _LAST_LETTER else "?" for c in name)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
