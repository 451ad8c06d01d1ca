"""The explanation that a record may carry."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from pydantic import TypeAdapter, ValidationError

from eai.abilities.explanation import Explanation
from eai.abilities.verdict import Verdict
from eai.errors import InputError

NOTHING_EXPLAINED = Explanation()
"""The explanation of a record without one."""


def explanation_of(verdict: Verdict) -> Explanation:
    """The explanation in a verdict's details, or an empty one.

    Raises:
        InputError: there is something else in its place.
    """
    found = (verdict.details or {}).get("explanation")
    if not isinstance(found, Mapping):
        return NOTHING_EXPLAINED
    try:
        return _adapter().validate_python(dict(found))
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"])
        raise InputError(f"field explanation.{field}: {first['msg']}") from error


@cache
def _adapter() -> TypeAdapter[Explanation]:
    return TypeAdapter(Explanation)
