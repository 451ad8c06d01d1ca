"""Forms of answers: what providers take."""

from __future__ import annotations

import pytest

from eai.abilities.answer_schema import closed, either, fits, listed, text


@pytest.mark.parametrize(
    ("choices", "length", "expected"),
    [
        ([1000], 10, True),
        ([1001], 10, False),
        ([500, 500], 10, True),
        ([500, 501], 10, False),
        ([250], 1000, True),
        ([251], 60, False),
    ],
)
def test_how_many_words_fit(choices: list[int], length: int, expected: bool) -> None:
    schemas = [text([f"{i:0{length}}" for i in range(count)]) for count in choices]
    assert fits(closed({"a": listed(either(schemas))})) == expected


def test_every_member_is_needed_and_no_other_is_allowed() -> None:
    assert closed({"a": text(), "b": text(["c"])}) == {
        "type": "object",
        "properties": {"a": {"type": "string"}, "b": {"type": "string", "enum": ["c"]}},
        "required": ["a", "b"],
        "additionalProperties": False,
    }
