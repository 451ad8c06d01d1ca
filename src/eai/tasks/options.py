"""Options: typed settings of runs and files, each with a description and limits.

`describe_validation_error` turns a validation error into a message for the person who wrote the value.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, JsonValue, PlainSerializer, ValidationError
from pydantic_core import PydanticCustomError
from typing_extensions import Self

from eai.base.docstrings import read_docstring_entries
from eai.base.errors import InputError, did_you_mean
from eai.base.files import read_toml

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
"""Names of types that pydantic appends to the path of a value if the option allows several types."""


def describe_validation_error(
    error: ValidationError,
    allowed_names: Iterable[str] = (),
    within: Iterable[str] = (),
    whole: str = "the line",
) -> str:
    """Return the first error of a validation in words: the path of the value, the expectation, and the value.

    Args:
        error: the error that pydantic raised.
        allowed_names: the allowed names. For an unknown name, the message suggests the most similar name.
        within: the path of the validated value in an enclosing structure, outermost name first.
        whole: the text in place of the path, if the complete value is wrong and ``within`` is empty.
    """
    errors = error.errors()
    first = errors[0]
    location = first["loc"]
    if location and location[-1] in _BRANCHES:
        value_location = location[:-1]
        depth = len(value_location)
        # a list fits its type except for the wrong value inside it
        first = max(
            (other for other in errors if other["loc"][:depth] == value_location),
            key=lambda other: len(other["loc"]),
        )
        location = value_location + first["loc"][depth + 1 :]
    path = [*within, *map(str, location)] or [whole]
    kind = first["type"]
    if kind in ("extra_forbidden", "unexpected_keyword_argument"):
        problem = f"unknown{did_you_mean(path[-1], allowed_names)}"
    elif kind == "missing":
        problem = "is missing"
    else:
        expected = _EXPECTED.get(kind, first["msg"].replace("Input should be", "expected"))
        problem = f"{expected}{_describe_wrong_value(first['input'])}"
    return f"{'.'.join(path)}: {problem}"


def _describe_wrong_value(value: Any) -> str:
    """Return the end of a message, which quotes a short wrong value; an empty text for a long value."""
    shown = repr(value)
    return f", found {shown}" if len(shown) <= 60 else ""


_SECRET = re.compile(r"(^|_)(key|token|secret|password|credentials|headers)$", re.IGNORECASE)


def remove_secrets(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return a model's arguments without keys, passwords and other secrets."""
    return {name: value for name, value in arguments.items() if not _SECRET.search(name)}


Arguments = Annotated[dict[str, JsonValue], PlainSerializer(remove_secrets)]
"""Arguments that a user gives for a model. Keys and other secrets in them are never written to a file."""


def _require_web_address(address: str) -> str:
    if not address.startswith(("http://", "https://")):
        raise PydanticCustomError("address_without_http", "expected http:// or https:// before the address")
    return address


WebAddress = Annotated[str, AfterValidator(_require_web_address)]
"""Address of a server, with its protocol."""


class Options(BaseModel):
    """Options in a section of the file that specifies a run, or of another file that users write.

    Each subclass declares its options as fields and describes them in its docstring. If a description is
    computed, it is the ``description`` of the field instead.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    @classmethod
    def read(cls, section: str, values: object) -> Self:
        """Return the options with the given values. Values that are texts are parsed as on the command line.

        Args:
            section: name of the section, for messages.
            values: mapping from names of options to their values.

        Raises:
            InputError: an option or a value is unknown, or options contradict each other.
        """
        try:
            return cls.model_validate({**values} if isinstance(values, Mapping) else values)
        except ValidationError as error:
            message = describe_validation_error(error, cls.model_fields, [section], section)
            if error.errors()[0]["type"] == "extra_forbidden":
                message += f" ({section} has {', '.join(cls.model_fields)})"
            raise InputError(message) from error

    @classmethod
    def read_file(cls, file: Path) -> Self:
        """Return the options in a TOML file.

        Raises:
            InputError: the file cannot be read, an option is missing or unknown, or a value is wrong.
        """
        try:
            return cls.model_validate(read_toml(file))
        except ValidationError as error:
            raise InputError(
                f"{file}: {describe_validation_error(error, cls.model_fields, whole='the file')}"
            ) from error

    @classmethod
    def describe_option(cls, option: str) -> str:
        """Return the meaning of an option."""
        described = cls.model_fields[option].description
        by_class = [
            read_docstring_entries(base.__doc__, "Attributes")
            for base in cls.__mro__
            if issubclass(base, Options)
        ]
        return described or next((by_name[option] for by_name in by_class if option in by_name), "")

    @classmethod
    def format_default(cls, option: str) -> str:
        """Return the default value of an option as a file states it; an empty text if it has no default."""
        field = cls.model_fields[option]
        value = None if field.is_required() else field.get_default(call_default_factory=True)
        if value in (None, (), {}):
            return ""
        if isinstance(value, tuple):
            return ",".join(str(getattr(item, "value", item)) for item in value)
        return str(value).lower() if isinstance(value, bool) else str(getattr(value, "value", value))
