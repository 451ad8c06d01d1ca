"""The names that a formula may use, the misuses of one that uses others, and places in a text."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from eai.base.errors import ParseError
from eai.logic.formula import Constant, Formula, Term, Variable


def error_at(text: str, position: int, expected: str) -> ParseError:
    """The error for an offset into the text."""
    return ParseError(*line_and_column(text, position), expected)


def line_and_column(text: str, position: int) -> tuple[int, int]:
    """Line and column, both counted from 1, of an offset into the text."""
    line_start = text.rfind("\n", 0, position) + 1
    return text.count("\n", 0, position) + 1, position - line_start + 1


def join_with_or(words: Sequence[str]) -> str:
    """One of several things: ``a, b or c``."""
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


MisuseKind: TypeAlias = Literal["unknown_predicate", "unknown_object", "wrong_arity"]
"""How a formula that parses can still be about nothing that exists.

``unknown_predicate``: the name is neither a predicate nor an action. ``unknown_object``: an argument is
neither an object nor a variable that is bound there. ``wrong_arity``: the predicate or action takes another
number of arguments.
"""


@dataclass(frozen=True, slots=True)
class Misuse:
    """One use of a name that the signature does not allow.

    ``line`` and ``column`` count from 1 and point at the offending name: the predicate for an unknown
    predicate or a wrong number of arguments, the argument for an unknown object. ``primitive`` is the
    predicate or action that it occurs in.
    """

    kind: MisuseKind
    name: str
    primitive: str
    line: int
    column: int
    detail: str

    def __str__(self) -> str:
        return f"line {self.line}, column {self.column}: {self.detail}"


@dataclass(frozen=True, slots=True)
class Signature:
    """The vocabulary of formulas: predicates and actions with their arities, and the objects.

    An arity of None allows any number of arguments. A name that is both a predicate and an action is a
    predicate. ``objects`` None allows every object name. ``known`` are formulas of primitives by their text,
    as far as a reader has met and remembered them: answers to one task have most primitives in common.
    """

    predicates: Mapping[str, int | None]
    actions: Mapping[str, int | None] = field(default_factory=dict)
    objects: Container[str] | None = None
    parsed: dict[str, Formula] = field(default_factory=dict, repr=False, compare=False)

    def is_action(self, name: str) -> bool:
        """Whether the name is an action and no predicate."""
        return name in self.actions and name not in self.predicates

    def arity_table(self, name: str) -> Mapping[str, int | None]:
        """Where the arity of a name is to be looked up: among the predicates if it is one of them."""
        return self.predicates if name in self.predicates else self.actions


def to_term(name: str, scope: frozenset[str]) -> Term:
    """The term that a name denotes below quantifiers that bind the names in ``scope``."""
    return Variable(name) if name in scope else Constant(name)


def describe_arity(name: str, arity: int, noun: str) -> str:
    """How many of something a name takes, in words: ``WALK takes 1 object``."""
    return f"{name} takes {arity} {noun}{'' if arity == 1 else 's'}"
