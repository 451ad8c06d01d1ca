"""S-expressions: the parentheses of PDDL as a tree, each node with its place in the text.

The reader is tolerant where tolerance loses nothing: comments, any white space, upper case, several groups
in a row, and a variable glued to the word before it (``(on?x)``). What it cannot read is an unbalanced
parenthesis or a nesting deeper than `MAX_DEPTH`, which is a `PddlError` with line and column. Meaning is
the business of `reader`.
"""

from __future__ import annotations

import re
from typing import ClassVar, TypeAlias

from eai.logic.place import place
from eai.pddl.offence import Offence, PddlError

_WORD = re.compile(r"[()]|\??[^\s();?]+|\?|;[^\n]*")

MAX_DEPTH = 100
"""How deep parentheses may nest; the data set needs 9."""


class Symbol:
    """A word, in lower case since PDDL does not distinguish case; ``offset`` counts characters from 0."""

    __slots__ = ("offset", "text")
    __match_args__: ClassVar = ("text",)

    def __init__(self, text: str, offset: int) -> None:
        self.text = text
        self.offset = offset


class Group:
    """A parenthesised list from ``offset``, its opening parenthesis, to ``end``, behind the closing one."""

    __slots__ = ("end", "items", "offset")
    __match_args__: ClassVar = ("items",)

    def __init__(self, items: tuple[SExpr, ...], offset: int, end: int) -> None:
        self.items = items
        self.offset = offset
        self.end = end


SExpr: TypeAlias = Symbol | Group


def error_at(text: str, offset: int, offence: Offence, expected: str) -> PddlError:
    """The error for a place in a text."""
    return PddlError(offence, *place(text, offset), expected)


def read_group(text: str, offset: int = 0) -> Group:
    """The first expression at or behind an offset, which must be a parenthesised list; the rest is not read.

    Raises:
        PddlError: there is none, or it is unbalanced.
    """
    found = _read(text, offset)
    if not isinstance(found, Group):
        raise error_at(
            text, len(text) if found is None else found.offset, Offence.MALFORMED, "a parenthesised list"
        )
    return found


def _read(text: str, offset: int) -> SExpr | None:
    """The next expression, or None at the end of the text."""
    pending: list[tuple[int, list[SExpr]]] = []
    for match in _WORD.finditer(text, offset):
        word, place = match.group(), match.start()
        node: SExpr
        if word == "(":
            pending.append((place, []))
            if len(pending) > MAX_DEPTH:
                raise error_at(text, place, Offence.MALFORMED, f"at most {MAX_DEPTH} nested parentheses")
            continue
        if word.startswith(";"):
            continue
        if word != ")":
            node = Symbol(word.lower(), place)
        elif pending:
            start, items = pending.pop()
            node = Group(tuple(items), start, match.end())
        else:
            raise error_at(text, place, Offence.UNBALANCED, "no closing parenthesis without an opening one")
        if not pending:
            return node
        pending[-1][1].append(node)
    if pending:
        raise error_at(text, pending[-1][0], Offence.UNBALANCED, "a partner for this opening parenthesis")
    return None
