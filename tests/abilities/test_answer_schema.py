"""Schemas of answers, within the limits of providers."""

from __future__ import annotations

import pytest

from eai.abilities.answer_schema import is_accepted, list_schema, object_schema, text_schema, union_schema


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
def test_schemas_have_a_maximum_number_of_words(choices: list[int], length: int, expected: bool) -> None:
    schemas = [text_schema([f"{i:0{length}}" for i in range(count)]) for count in choices]
    assert is_accepted(object_schema({"a": list_schema(union_schema(schemas))})) == expected


def test_every_member_is_needed_and_no_other_is_allowed() -> None:
    assert object_schema({"a": text_schema(), "b": text_schema(["c"])}) == {
        "type": "object",
        "properties": {"a": {"type": "string"}, "b": {"type": "string", "enum": ["c"]}},
        "required": ["a", "b"],
        "additionalProperties": False,
    }
