"""Grammar files turned into parsers, and what lark says about a malformed text turned into a `ParseError`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from eai.errors import ParseError

ParseTree = Tree[Token]


@cache
def load(name: str, starts: tuple[str, ...] = ("start",)) -> Lark:
    """The LALR parser for a grammar file of this package and its start rules, built on first use."""
    return Lark.open(
        name, rel_to=str(Path(__file__)), parser="lalr", start=list(starts), maybe_placeholders=False
    )


def parse_tree(grammar: str, text: str, words: Mapping[str, str], start: str = "start") -> ParseTree | Token:
    """Parse a text with one of the grammar files.

    Args:
        grammar: the file's name.
        text: what to parse.
        words: for terminals of the grammar, what a user would call them; a terminal that is missing here is
            not worth mentioning when it could have stood somewhere.
        start: the rule that the whole text must match.

    Raises:
        ParseError: the text is not in the language.
    """
    try:
        return load(grammar, (start,)).parse(text)
    except UnexpectedInput as error:
        position = len(text) if _at_end(error) else error.pos_in_stream
        raise error_at(text, position or 0, expectation(_allowed(error), words)) from None


def error_at(text: str, position: int, expected: str) -> ParseError:
    """The error for an offset into the text."""
    line, column = place(text, position)
    return ParseError(text, line, column, expected)


def place(text: str, position: int) -> tuple[int, int]:
    """Line and column, both counted from 1, of an offset into the text."""
    line_start = text.rfind("\n", 0, position) + 1
    return text.count("\n", 0, position) + 1, position - line_start + 1


def expectation(terminals: Iterable[str], words: Mapping[str, str]) -> str:
    """What could have stood at a place, in words: ``a, b or c`` in the order of ``words``."""
    allowed = set(terminals)
    named = list(dict.fromkeys(word for terminal, word in words.items() if terminal in allowed))
    return either(named) or "the end"


def either(words: Sequence[str]) -> str:
    """One of several things: ``a, b or c``."""
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


def _at_end(error: UnexpectedInput) -> bool:
    return isinstance(error, UnexpectedToken) and error.token.type == "$END"


def _allowed(error: UnexpectedInput) -> set[str]:
    if isinstance(error, UnexpectedToken):
        return set(error.accepts or error.expected)
    if isinstance(error, UnexpectedCharacters):
        return set(error.allowed or ())
    return set()
