"""Reading the texts of records again: atoms, steps and goals, as explanations print them."""

from __future__ import annotations

from typing import NamedTuple

_NOT = "not "


class Call(NamedTuple):
    """An atom or an action: ``not open(jar_0)``, ``GRAB(soap.1002)``, ``TOUCH``.

    Attributes:
        name: of the predicate or action.
        arguments: of the objects; None where the text has no parentheses, as of actions that are goals.
        positive: whether it is asserted.
    """

    name: str
    arguments: tuple[str, ...] | None
    positive: bool = True


def read_call(text: str) -> Call:
    """What an atom or a step says; a text of any other form is a name."""
    positive = not text.startswith(_NOT)
    name, opened, rest = (text if positive else text[len(_NOT) :]).partition("(")
    if not opened or not rest.endswith(")"):
        return Call(text, None)
    return Call(name, tuple(part for part in rest[:-1].split(", ") if part), positive)
