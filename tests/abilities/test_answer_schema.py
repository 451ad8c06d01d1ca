"""Schemas of answers, within the limits of providers."""

from __future__ import annotations

import pytest

from eai.abilities.answer_schema import (
    is_schema_accepted_by_providers,
    make_list_schema,
    make_object_schema,
    make_text_schema,
    make_union_schema,
)


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
    schemas = [make_text_schema([f"{i:0{length}}" for i in range(count)]) for count in choices]
    assert (
        is_schema_accepted_by_providers(
            make_object_schema({"a": make_list_schema(make_union_schema(schemas))})
        )
        == expected
    )


def test_every_member_is_needed_and_no_other_is_allowed() -> None:
    assert make_object_schema({"a": make_text_schema(), "b": make_text_schema(["c"])}) == {
        "type": "object",
        "properties": {"a": {"type": "string"}, "b": {"type": "string", "enum": ["c"]}},
        "required": ["a", "b"],
        "additionalProperties": False,
    }
