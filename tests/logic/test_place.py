"""Places and expectations in error messages."""

from __future__ import annotations

import pytest

from eai.logic.place import either, place


@pytest.mark.parametrize(
    ("position", "line_and_column"), [(0, (1, 1)), (2, (1, 3)), (3, (2, 1)), (4, (3, 1)), (6, (3, 3))]
)
def test_place(position: int, line_and_column: tuple[int, int]) -> None:
    assert place("ab\n\ncd", position) == line_and_column


def test_a_text_may_begin_with_an_empty_line() -> None:
    assert place("\nab", 2) == (2, 2)


def test_only_newlines_end_lines() -> None:
    assert place("a\fb\x85c\rd", 6) == (1, 7)


@pytest.mark.parametrize(
    ("words", "told"), [(["a"], "a"), (["a", "c"], "a or c"), (["a", "b", "c"], "a, b or c")]
)
def test_alternatives_in_words(words: list[str], told: str) -> None:
    assert either(words) == told
