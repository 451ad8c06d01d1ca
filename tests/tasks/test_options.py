from __future__ import annotations

from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from eai.tasks.options import Options, describe_validation_error


class Shape(BaseModel):
    model_config = ConfigDict(extra="forbid")

    name: Annotated[str, Field(min_length=1)]
    version: Literal[1] = 1
    parts: list[str | list[str]] = []
    counts: dict[str, int] = {}
    facts: dict[str, list[str | list[str]]] = {}


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({}, "name: is missing"),
        ({"name": 3}, "name: expected a string, found 3"),
        ({"name": ""}, "name: expected a text that is not empty, found ''"),
        ({"name": "a", "version": 2}, "version: expected 1, found 2"),
        ({"name": "a", "parts": "b"}, "parts: expected a list, found 'b'"),
        ({"name": "a", "parts": ["b", 3]}, "parts.1: expected a string, found 3"),
        ({"name": "a", "parts": ["b", ["c", 3]]}, "parts.1.1: expected a string, found 3"),
        ({"name": "a", "facts": {"on": [["c", 3]]}}, "facts.on.0.1: expected a string, found 3"),
        ({"name": "a", "facts": {"on": [["c"], 3]}}, "facts.on.1: expected a string, found 3"),
        ({"name": "a", "parts": [["b", 3]], "verison": 1}, "parts.0.1: expected a string, found 3"),
        ({"name": "a", "counts": []}, "counts: expected an object, found []"),
        ({"name": "a", "counts": {"b": "c" * 99}}, "counts.b: expected a whole number"),
        ({"name": "a", "verison": 1}, "verison: unknown; did you mean version?"),
        ({"name": "a", "colour": 1}, "colour: unknown"),
        (3, "the line: expected an object, found 3"),
    ],
)
def test_what_is_wrong_is_said_with_place_and_expectation(value: object, said: str) -> None:
    with pytest.raises(ValidationError) as caught:
        Shape.model_validate(value)
    assert describe_validation_error(caught.value, Shape.model_fields) == said


class Lamp(Options):
    """A lamp.

    Attributes:
        colour: The colour of its light.
        height: The height in metres.
    """

    colour: str = "white"
    height: float = 1.0


class DeskLamp(Lamp):
    """A lamp on a desk.

    Attributes:
        height: The height above the desk.
    """

    height: float = 0.5


def test_an_inherited_option_keeps_its_meaning_and_a_redeclared_option_has_its_own() -> None:
    assert DeskLamp.describe_option("colour") == "The colour of its light."
    assert DeskLamp.describe_option("height") == "The height above the desk."


class Shelf(Options):
    """A shelf.

    Attributes:
        width: The width in metres.
        boards: The heights of its boards.
        books: The names of books on it.
        has_back: Whether it has a back.
    """

    width: float
    boards: tuple[int, ...] = Field(default_factory=lambda: (1, 2))
    books: tuple[str, ...] = Field(default_factory=tuple)
    has_back: bool = True


@pytest.mark.parametrize(
    ("option", "text"), [("width", ""), ("boards", "1,2"), ("books", ""), ("has_back", "true")]
)
def test_a_default_is_formatted_as_a_file_states_it(option: str, text: str) -> None:
    assert Shelf.format_default(option) == text
