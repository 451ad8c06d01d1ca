"""Signatures (the names that a formula may use), misuses of names, and positions in a text."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from eai.base.errors import ParseError
from eai.logic.formula import Constant, Formula, Term, Variable


def make_parse_error(text: str, position: int, expected: str) -> ParseError:
    """Return a ParseError with the line and column of an offset in a text."""
    return ParseError(*find_line_and_column(text, position), expected)


def find_line_and_column(text: str, position: int) -> tuple[int, int]:
    """Return the line and column of an offset in a text, both counted from 1."""
    line_start = text.rfind("\n", 0, position) + 1
    return text.count("\n", 0, position) + 1, position - line_start + 1


def join_with_or(words: Sequence[str]) -> str:
    """Join words as alternatives: ``a, b or c``."""
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else "".join(words)


NameMisuseKind: TypeAlias = Literal["unknown_predicate", "unknown_object", "wrong_arity"]
"""Kind of misuse of a name in a formula without syntax errors.

``unknown_predicate``: the name is neither a predicate nor an action. ``unknown_object``: an argument is
neither an object nor a bound variable. ``wrong_arity``: the predicate or action takes another number of
arguments.
"""


@dataclass(frozen=True, slots=True)
class NameMisuse:
    """A use of a name that the signature does not allow.

    Attributes:
        kind: the kind of misuse.
        name: the misused name: the unknown object, or else the predicate or action.
        primitive: the predicate or action whose argument or name is misused; ``=`` for an equation.
        line: line of the name, counted from 1.
        column: column of the name, counted from 1.
        detail: description of the misuse.
    """

    kind: NameMisuseKind
    name: str
    primitive: str
    line: int
    column: int
    detail: str

    def __str__(self) -> str:
        return f"line {self.line}, column {self.column}: {self.detail}"


@dataclass(frozen=True, slots=True)
class FormulaSignature:
    """The names that formulas may use: predicates and actions with their arities, and objects.

    Attributes:
        predicates: mapping from predicates to arities; the arity None allows any number of arguments.
        actions: mapping from actions to arities. A name that is both a predicate and an action is a
            predicate.
        objects: the names of objects; None allows every name.
        parsed: mapping from texts to parsed atoms and actions. It is a cache, since answers to one task share
            most atoms and actions.
    """

    predicates: Mapping[str, int | None]
    actions: Mapping[str, int | None] = field(default_factory=dict)
    objects: Container[str] | None = None
    parsed: dict[str, Formula] = field(default_factory=dict, repr=False, compare=False)

    def is_action(self, name: str) -> bool:
        """Whether the name is an action and not a predicate."""
        return name in self.actions and name not in self.predicates

    def get_arities_of_names_of_same_kind(self, predicate_or_action: str) -> Mapping[str, int | None]:
        """Return the arities of all predicates if the given name is a predicate, else of all actions.

        The arity None allows any number of arguments.
        """
        return self.predicates if predicate_or_action in self.predicates else self.actions


def make_term(name: str, scope: frozenset[str]) -> Term:
    """Return the term for a name: a variable if the name is in ``scope``, else an object."""
    return Variable(name) if name in scope else Constant(name)


def describe_arity(name: str, arity: int, noun: str) -> str:
    """Return a text about the required number of arguments of a name: ``WALK takes 1 object``."""
    return f"{name} takes {arity} {noun}{'' if arity == 1 else 's'}"


def describe_wrong_arity(name: str, arity: int, noun: str, actual: int) -> str:
    """Return a text about a wrong number of arguments: ``WALK takes 1 object, not 2``."""
    return f"{describe_arity(name, arity, noun)}, not {actual}"
