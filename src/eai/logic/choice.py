"""What there is to choose when a formula is to be made true: its ground and-or tree.

The tree is polynomial in the number of objects, while the number of ways to choose is exponential. Options
are listed, counted and rated on it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from eai.errors import InputError
from eai.logic.formula import (
    And,
    Atom,
    Constant,
    Equals,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Variable,
)

Literal: TypeAlias = Atom | Occurs | Not
"""A ground atom, an action with its objects, or the negation of one of them."""


class Universe(Protocol):
    """The objects that variables range over; every `Interpretation` is one."""

    def objects(self, category: str | None) -> Sequence[str]:
        """The objects of a category, each once, in a fixed order; None means all objects."""
        ...


@dataclass(frozen=True, slots=True)
class Leaf:
    """A condition that is to hold; nothing to choose."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class AllOf:
    """Every part is to be made true."""

    parts: tuple[Choice, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    """One part is to be made true."""

    parts: tuple[Choice, ...]


@dataclass(frozen=True, slots=True)
class Choose:
    """``count`` different parts are to be made true."""

    count: int
    parts: tuple[Choice, ...]


@dataclass(frozen=True, slots=True)
class Pairing:
    """``count`` cells are to be made true, no two in one row or column; None marks what is no pair."""

    count: int
    cells: tuple[tuple[Choice | None, ...], ...]


Choice: TypeAlias = Leaf | AllOf | AnyOf | Choose | Pairing


def ground(formula: Formula, universe: Universe) -> Choice:
    """The choices that a closed formula leaves; negation is pushed inwards to the conditions.

    ``then`` is read as a conjunction in a given order. For ``forn`` exactly that many instances are chosen
    and nothing is said about the others; a pairing takes as many pairs as the smaller category has objects
    (both as in bddl, ``condition_evaluation.py``), and no object is paired with itself.

    Raises:
        InputError: a variable is not bound; or a part leaves no finite choice of conditions: a temporal
            operator other than ``then``, a negated ``then`` or a negated counting quantifier.
    """
    return _Grounding(universe).ground(formula, {}, True)


def literals(choice: Choice) -> Iterator[Literal]:
    """The conditions at the leaves, left to right."""
    match choice:
        case Leaf(literal):
            yield literal
        case Pairing(_, cells):
            for cell in (cell for row in cells for cell in row if cell is not None):
                yield from literals(cell)
        case AllOf(parts) | AnyOf(parts) | Choose(_, parts):
            for part in parts:
                yield from literals(part)


class _Grounding:
    def __init__(self, universe: Universe) -> None:
        self._universe = universe

    def ground(self, formula: Formula, binding: Mapping[str, str], positive: bool) -> Choice:
        match formula:
            case Atom() | Occurs() | Equals():
                return _condition(formula, binding, positive)
            case Not(operand):
                return self.ground(operand, binding, not positive)
            case And(operands) | Or(operands):
                parts = tuple([self.ground(operand, binding, positive) for operand in operands])
                return AllOf(parts) if isinstance(formula, And) == positive else AnyOf(parts)
            case Implies(premise, conclusion):
                return self.ground(Or((Not(premise), conclusion)), binding, positive)
            case ForAll(variable, body) | Exists(variable, body):
                parts = self._instances(variable, body, binding, positive)
                return AllOf(parts) if isinstance(formula, ForAll) == positive else AnyOf(parts)
            case Exactly(count, variable, body) if positive:
                return Choose(count, self._instances(variable, body, binding, True))
            case ForPairs() if positive:
                return self._pairing(formula, binding)
            case Then(steps) if positive:
                return AllOf(tuple([self.ground(step, binding, True) for step in steps]))
            case _:
                negated = "" if positive else "a negated "
                raise InputError(f"{negated}{type(formula).__name__} leaves no finite choice of conditions")

    def _instances(
        self, variable: Variable, body: Formula, binding: Mapping[str, str], positive: bool
    ) -> tuple[Choice, ...]:
        values = self._universe.objects(variable.category)
        return tuple([self.ground(body, {**binding, variable.name: value}, positive) for value in values])

    def _pairing(self, formula: ForPairs, binding: Mapping[str, str]) -> Pairing:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._universe.objects(first.category), self._universe.objects(second.category)

        def cell(x: str, y: str) -> Choice | None:
            return None if x == y else self.ground(body, {**binding, first.name: x, second.name: y}, True)

        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return Pairing(count, tuple(tuple(cell(x, y) for y in columns) for x in rows))


def _condition(formula: Atom | Occurs | Equals, binding: Mapping[str, str], positive: bool) -> Choice:
    match formula:
        case Equals(left, right):
            true = value_of(left, binding) == value_of(right, binding)
            return AllOf(()) if true == positive else AnyOf(())
        case Atom(predicate, arguments):
            literal: Atom | Occurs = Atom(predicate, tuple([value_of(t, binding) for t in arguments]))
        case Occurs(action, arguments):
            literal = Occurs(action, tuple([value_of(t, binding) for t in arguments]))
    return Leaf(literal if positive else Not(literal))


def value_of(term: Term, binding: Mapping[str, str]) -> Constant:
    """The object that a term denotes when variables have these values.

    Raises:
        InputError: it is a variable without a value.
    """
    if isinstance(term, Constant):
        return term
    if term.name not in binding:
        raise InputError(f"variable {term.name} is not bound by a quantifier")
    return Constant(binding[term.name])
