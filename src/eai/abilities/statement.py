"""The statements of a record, as values beside the texts: atoms, actions and steps."""

from __future__ import annotations

from typing import NamedTuple

_NOT = "not "


class Statement(NamedTuple):
    """An atom or an action: ``not open(jar_0)``, ``GRAB(soap.1002)``, ``TOUCH``.

    Attributes:
        name: of the predicate or action.
        arguments: of the objects; None where the text has no parentheses, as of actions that are goals.
        positive: whether it is asserted.
    """

    name: str
    arguments: tuple[str, ...] | None
    positive: bool = True

    @property
    def signed_name(self) -> str:
        """The name, after ``not`` where the statement is denied."""
        return self.name if self.positive else f"{_NOT}{self.name}"


def read_statement(text: str) -> Statement:
    """The atom or step in a text that has no value beside it, as in older records; else it is a name."""
    positive = not text.startswith(_NOT)
    name, opened, rest = (text if positive else text[len(_NOT) :]).partition("(")
    if not opened or not rest.endswith(")"):
        return Statement(text, None)
    return Statement(name, tuple([part for part in rest[:-1].split(", ") if part]), positive)
