"""The exceptions of the package. An expected failure of an answer is a value, never one of these.

EaiError
├── InputError     a file, an argument or a declaration that the user can mend: place, expectation
│   ├── ParseError a text that does not parse: line, column, what was expected
│   └── DomainError a domain's declaration contradicts itself: names the declaration
├── DataError      the data set is missing, damaged or cannot be obtained: says what to do
└── InterruptError the user ended it: says how to go on
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
    """Root of the tree; its text is one line that a user can act on."""


class InputError(EaiError):
    """Input that cannot be used; the message names the file, the place and what was expected."""


class ParseError(InputError):
    """A text that does not parse.

    Args:
        line: the offending line, counted from 1.
        column: the offending column, counted from 1.
        expected: what could have stood there, in words.
    """

    def __init__(self, line: int, column: int, expected: str) -> None:
        super().__init__(f"line {line}, column {column}: expected {expected}")
        self.line = line
        self.column = column
        self.expected = expected


class DomainError(InputError):
    """A domain's declaration contradicts itself; the message names the declaration."""


class DataError(EaiError):
    """The data set is missing, damaged or cannot be obtained; the message says what to do."""


class InterruptError(EaiError):
    """The user ended it; the message says how to go on."""


def install_command(extra: str) -> str:
    """The command that installs what an extra of the package consists of."""
    return f"pip install 'eai-bench[{extra}]'"


@contextmanager
def require_extra(extra: str, message_start: str) -> Iterator[None]:
    """Within it, what an extra of the package consists of is imported.

    Args:
        extra: the extra.
        message_start: the beginning of the message: what needs the package, with the verb.

    Raises:
        EaiError: a part of it is not installed.
    """
    try:
        yield
    except ImportError as error:
        package = error.name.partition(".")[0] if error.name else f"a package that loads ({error})"
        raise EaiError(f"{message_start} {package}: {install_command(extra)}") from error


@contextmanager
def prefix_errors(location: object, kind: type[InputError] = InputError) -> Iterator[None]:
    """Within it, the message of an error of a kind begins with the place of what is wrong."""
    try:
        yield
    except kind as error:
        raise kind(f"{location}: {error}") from error


def read_all(items: Iterable[S], read: Callable[[S], T]) -> list[T]:
    """Return what a function reads from each item.

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


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a message on an unknown name: the known one that is nearest, or nothing if none is near."""
    near = get_close_matches(word, list(known), 1)
    return f"; did you mean {near[0]}?" if near and near[0] != word else ""


def find_member(kind: type[E], name: E | str, noun: str) -> E:
    """Return the member of an enumeration that has a value.

    Args:
        kind: the enumeration.
        name: the value, or the member itself.
        noun: the noun for a member, for the message.

    Raises:
        InputError: no member has this value.
    """
    try:
        return kind(name)
    except ValueError as error:
        raise unknown_name_error(str(name), noun, [each.value for each in kind]) from error


def unknown_name_error(name: str, noun: str, known: Iterable[str]) -> InputError:
    """Return the error for an unknown name. It lists the known names; ``noun`` says what they name."""
    return InputError(f"{name!r} is no {noun}: expected one of {', '.join(known)}{did_you_mean(name, known)}")
