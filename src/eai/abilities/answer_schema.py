"""JSON schemas for answers.

Some providers make sure that a model's answer fits a schema. The schemas use only features that all these
providers support. An object has exactly its declared members. A text may be limited to a list of words.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

from eai.base.json_value import Json

Schema: TypeAlias = Mapping[str, Json]
"""A JSON schema."""

MAX_ENUM_WORDS = 1000
"""Maximum number of words in all enumerations (``enum``) of a schema: OpenAI's limit, the smallest known."""

MAX_SHORT_ENUM_WORDS = 250
"""Maximum number of words of a short enumeration (``enum``). A longer one has a limit of characters, too."""
MAX_LONG_ENUM_CHARACTERS = 15_000
"""Maximum number of characters in all words of a long enumeration (more than `MAX_SHORT_ENUM_WORDS`)."""


def make_text_schema(words: Iterable[str] | None = None) -> Schema:
    """Return the schema of a text: any of some words, or any text at all if `words` is None."""
    return {"type": "string"} if words is None else {"type": "string", "enum": list(words)}


def make_list_schema(items: Schema) -> Schema:
    """Return the schema of a list, given the schema of its items."""
    return {"type": "array", "items": items}


def make_object_schema(members: Mapping[str, Schema]) -> Schema:
    """Return the schema of an object with exactly the given members, each with its schema."""
    return {
        "type": "object",
        "properties": members,
        "required": list(members),
        "additionalProperties": False,
    }


def make_union_schema(schemas: Sequence[Schema]) -> Schema:
    """Return the schema of a value that fits at least one of several schemas."""
    return schemas[0] if len(schemas) == 1 else {"anyOf": schemas}


def is_schema_accepted_by_providers(schema: Schema) -> bool:
    """Whether a schema keeps all providers' limits on the numbers of words and characters."""
    choices = [list(map(str, choice)) for choice in _list_enumerated_values(schema)]
    return sum(map(len, choices)) <= MAX_ENUM_WORDS and all(
        len(choice) <= MAX_SHORT_ENUM_WORDS or sum(map(len, choice)) <= MAX_LONG_ENUM_CHARACTERS
        for choice in choices
    )


def _list_enumerated_values(schema: Json) -> Iterator[Sequence[Json]]:
    """Yield the words of each enumeration in a schema."""
    if isinstance(schema, Mapping):
        words = schema.get("enum")
        if isinstance(words, list):
            yield words
        for member in schema.values():
            yield from _list_enumerated_values(member)
    elif isinstance(schema, list):
        for member in schema:
            yield from _list_enumerated_values(member)
