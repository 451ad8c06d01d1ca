"""The form of answers as JSON schemas, in what all providers have in common that enforce one.

Objects are closed and need all of their members; a text may have to be one of some words.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

from eai.base.json_value import Json

Schema: TypeAlias = Mapping[str, Json]
"""A JSON schema."""

MOST_WORDS = 1000
"""How many words a schema may offer in all (OpenAI's limit, the narrowest that is published)."""

MANY_WORDS = 250
MOST_CHARACTERS = 15_000
"""Of how many characters the words of one choice may be, where there are more than `MANY_WORDS`."""


def text(words: Iterable[str] | None = None) -> Schema:
    """A text: one of these words, or any where None are given."""
    return {"type": "string"} if words is None else {"type": "string", "enum": list(words)}


def listed(items: Schema) -> Schema:
    """A list."""
    return {"type": "array", "items": items}


def closed(members: Mapping[str, Schema]) -> Schema:
    """An object with these members and no others."""
    return {
        "type": "object",
        "properties": members,
        "required": list(members),
        "additionalProperties": False,
    }


def either(schemas: Sequence[Schema]) -> Schema:
    """A value that has one of these forms."""
    return schemas[0] if len(schemas) == 1 else {"anyOf": schemas}


def fits(schema: Schema) -> bool:
    """Whether providers take as many words."""
    choices = [list(map(str, choice)) for choice in _choices(schema)]
    return sum(map(len, choices)) <= MOST_WORDS and all(
        len(choice) <= MANY_WORDS or sum(map(len, choice)) <= MOST_CHARACTERS for choice in choices
    )


def _choices(part: Json) -> Iterator[Sequence[Json]]:
    """The words of each choice in a schema."""
    if isinstance(part, Mapping):
        words = part.get("enum")
        if isinstance(words, list):
            yield words
        for each in part.values():
            yield from _choices(each)
    elif isinstance(part, list):
        for each in part:
            yield from _choices(each)
