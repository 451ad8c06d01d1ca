"""Options: values of which a run is made, each with its meaning and limits for all who take or list them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, JsonValue, PlainSerializer, ValidationError
from typing_extensions import Self

from eai.abilities.misfit import misfit
from eai.errors import InputError

_SECRET = re.compile(r"(^|_)(key|token|secret|password|credentials|headers)$", re.IGNORECASE)


def _without_secrets(arguments: dict[str, JsonValue]) -> dict[str, JsonValue]:
    return {name: value for name, value in arguments.items() if not _SECRET.search(name)}


Arguments = Annotated[dict[str, JsonValue], PlainSerializer(_without_secrets)]
"""Arguments of a model; its keys are in no file."""


def option(meaning: str, default: object = None, **limits: float) -> Any:
    """An option: what it means, its value if nothing is chosen, and limits (``ge``, ``le``)."""
    field: Any = Field
    return field(default=default, description=meaning, **limits)


class Options(BaseModel):
    """A section of a run's specification; subclasses declare the options, with a description each."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def read(cls, section: str, given: object) -> Self:
        """The options with given values; texts are read as the command line has them.

        Args:
            section: the name of the section, for messages.
            given: a mapping of names to values.

        Raises:
            InputError: there is no such option, it has no such value, or options contradict each other.
        """
        try:
            return cls.model_validate({**given} if isinstance(given, Mapping) else given)
        except ValidationError as error:
            known = f" ({section} has {', '.join(cls.model_fields)})"
            unknown = error.errors()[0]["type"] == "extra_forbidden"
            said = misfit(error, cls.model_fields, [section], section)
            raise InputError(f"{said}{known if unknown else ''}") from error

    @classmethod
    def about(cls, option: str) -> str:
        """The meaning of an option."""
        return cls.model_fields[option].description or ""
