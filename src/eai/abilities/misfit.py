"""What is wrong with a value that should have a certain shape, in words for who wrote it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError

from eai.errors import did_you_mean

_EXPECTED = {
    "string_type": "expected a string",
    "string_too_short": "expected a text that is not empty",
    "list_type": "expected a list",
    "tuple_type": "expected a list",
    "too_short": "expected a list that is not empty",
    "dict_type": "expected an object",
    "model_type": "expected an object",
    "dataclass_type": "expected an object",
    "int_type": "expected a whole number",
    "int_parsing": "expected a whole number",
    "int_from_float": "expected a whole number",
}
_BRANCHES = ("str", "list[str]")
"""What pydantic puts after the place where a value may be of several types."""


def misfit(
    error: ValidationError, known: Iterable[str] = (), within: Iterable[str] = (), whole: str = "the line"
) -> str:
    """The first thing that is wrong: its place in the value, what was expected and what was found.

    Args:
        error: pydantic's.
        known: the names that members may have, of which the nearest to an unknown one is named.
        within: where in something larger the value stands, outermost first.
        whole: what the value is called if it is wrong as a whole.
    """
    first = error.errors()[0]
    place = [*within, *map(str, first["loc"])] or [whole]
    if place[-1] in _BRANCHES:
        place.pop()
    kind = first["type"]
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        said = f"unknown{did_you_mean(place[-1], known)}"
    elif kind == "missing":
        said = "is missing"
    else:
        expected = _EXPECTED.get(kind, first["msg"].replace("Input should be", "expected"))
        said = f"{expected}{_found(first['input'])}"
    return f"{'.'.join(place)}: {said}"


def _found(value: Any) -> str:
    """The value, where it is short enough to be shown."""
    shown = repr(value)
    return f", found {shown}" if len(shown) <= 60 else ""
