"""Places in a text, and the error that something else should stand at one."""

from __future__ import annotations

from collections.abc import Sequence

from eai.errors import ParseError


def error_at(text: str, position: int, expected: str) -> ParseError:
    """The error for an offset into the text."""
    return ParseError(*place(text, position), expected)


def place(text: str, position: int) -> tuple[int, int]:
    """Line and column, both counted from 1, of an offset into the text."""
    line_start = text.rfind("\n", 0, position) + 1
    return text.count("\n", 0, position) + 1, position - line_start + 1


def either(words: Sequence[str]) -> str:
    """One of several things: ``a, b or c``."""
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)
