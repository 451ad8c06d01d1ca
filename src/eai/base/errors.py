"""The exceptions of the package. A wrong answer of a model is a value, and raises no exception.

EaiError
├── InputError: a wrong file, argument or declaration; the message names the place and the expected form
│   ├── ParseError: a text that does not parse; line, column and the expected text
│   └── DomainError: a domain's declaration contradicts itself; the message names the declaration
├── DataError: the data set is missing, damaged or cannot be obtained; the message gives the remedy
└── UserInterruptError: the user ended the command; the message explains how to continue
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from enum import Enum
from typing import TypeVar

E = TypeVar("E", bound=Enum)
S = TypeVar("S")
T = TypeVar("T")


class EaiError(Exception):
    """Base class of the exceptions of the package. Its message is one line that tells the user what to do."""


class InputError(EaiError):
    """Input is wrong. The message names the file, the place in the file and the expected form."""


class ParseError(InputError):
    """A text does not parse.

    Args:
        line: line of the error, counted from 1.
        column: column of the error, counted from 1.
        expected: description of the text that the grammar allows there.
    """

    def __init__(self, line: int, column: int, expected: str) -> None:
        super().__init__(f"line {line}, column {column}: expected {expected}")
        self.line = line
        self.column = column
        self.expected = expected


class DomainError(InputError):
    """A domain's declaration contradicts itself; the message names the declaration."""


class DataError(EaiError):
    """The data set is missing, damaged or cannot be obtained. The message tells the user what to do."""


class UserInterruptError(EaiError):
    """The user ended the command. The message tells the user how to continue."""


def make_install_command(extra: str) -> str:
    """Return the shell command that installs an optional group of dependencies (extra), such as ``tui``."""
    return f"pip install 'eai-bench[{extra}]'"


@contextmanager
def require_extra(extra: str, error_message_start: str) -> Iterator[None]:
    """Convert the ImportError of a missing package to an error that names the extra to install.

    An extra is an optional group of dependencies.

    Args:
        extra: the extra, such as ``tui``.
        error_message_start: first words of the error message, up to its verb, such as ``eai play needs``.

    Raises:
        EaiError: a package of the extra is not installed.
    """
    try:
        yield
    except ImportError as error:
        package = error.name.partition(".")[0] if error.name else f"a package that loads ({error})"
        raise EaiError(f"{error_message_start} {package}: {make_install_command(extra)}") from error


@contextmanager
def prefix_errors_with_location(
    location: object, error_type: type[InputError] = InputError
) -> Iterator[None]:
    """Put a location, such as a file name, before the message of an error that the block raises."""
    try:
        yield
    except error_type as error:
        raise error_type(f"{location}: {error}") from error


def read_items_or_raise_all(items: Iterable[S], read: Callable[[S], T]) -> list[T]:
    """Apply a reading function to each item, and return the list of the results.

    Raises:
        InputError: an item cannot be read; the message has a line for each such item.
    """
    values: list[T] = []
    errors: list[InputError] = []
    for item in items:
        try:
            values.append(read(item))
        except InputError as error:
            errors.append(error)
    if len(errors) == 1:
        raise errors[0]
    if errors:
        raise InputError("\n".join(map(str, errors)))
    return values


def did_you_mean(word: str, known_names: Iterable[str]) -> str:
    """Return "; did you mean NAME?" with the most similar known name, or "" if no name is similar.

    A known name that differs only in capital letters counts as the most similar.
    """
    known = list(known_names)
    same_letters = [name for name in known if name.casefold() == word.casefold()]
    matches = same_letters or get_close_matches(word, known, 1)
    return f"; did you mean {matches[0]}?" if matches and matches[0] != word else ""


def find_enum_member(enum_type: type[E], name: E | str, noun: str) -> E:
    """Return the member of an enumeration that has the given value.

    Args:
        enum_type: the enumeration.
        name: the value of a member, or the member itself.
        noun: the noun for the members in the error message, such as ``"suite"``.

    Raises:
        InputError: no member has this value.
    """
    try:
        return enum_type(name)
    except ValueError as error:
        raise make_unknown_name_error(str(name), noun, [item.value for item in enum_type]) from error


def make_unknown_name_error(name: str, noun: str, known_names: Iterable[str]) -> InputError:
    """Return the error for an unknown name; its message lists the known names.

    Args:
        name: the unknown name.
        noun: the noun for the named objects in the error message, such as ``"suite"``.
        known_names: the known names.
    """
    return InputError(
        f"{name!r} is no {noun}: expected one of {', '.join(known_names)}{did_you_mean(name, known_names)}"
    )
