"""The choices that are left when a formula is to be made true: its ground and-or tree.

The tree is polynomial in the number of objects, while the number of ways to choose is exponential. Options
are listed, counted and rated on it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

import eai.logic.formula as f
from eai.errors import InputError

Literal: TypeAlias = f.Atom | f.Occurs | f.Not
"""A ground atom, an action with its objects, or the negation of one of them."""


Objects: TypeAlias = Callable[[str | None], Sequence[str]]
"""The objects that variables range over: those of a category, each once, in a fixed order; of None all."""


T = TypeVar("T")
"""A part of a choice: a choice again, or a condition that may leave more to choose."""


@dataclass(frozen=True, slots=True)
class Leaf:
    """A condition that is to hold; nothing to choose."""

    literal: Literal


@dataclass(frozen=True, slots=True)
class AllOf(Generic[T]):
    """Every part is to be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class AnyOf(Generic[T]):
    """One part is to be made true."""

    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class Choose(Generic[T]):
    """``count`` different parts are to be made true."""

    count: int
    parts: tuple[T, ...]


@dataclass(frozen=True, slots=True)
class Pairing(Generic[T]):
    """``count`` cells are to be made true, no two in one row or column; None marks what is no pair."""

    count: int
    cells: tuple[tuple[T | None, ...], ...]


Choice: TypeAlias = "Leaf | AllOf[Choice] | AnyOf[Choice] | Choose[Choice] | Pairing[Choice]"


def ground(formula: f.Formula, objects: Objects) -> Choice:
    """The choices that a closed formula leaves; negation is pushed inwards to the conditions.

    ``then`` is read as a conjunction in a given order. For ``forn`` exactly that many instances are chosen
    and nothing is said about the others; a pairing takes as many pairs as the smaller category has objects
    (both as in bddl, ``condition_evaluation.py``), and no object is paired with itself.

    Raises:
        InputError: a variable is not bound; or a part leaves no finite choice of conditions: a temporal
            operator other than ``then``, a negated ``then`` or a negated counting quantifier.
    """
    return _Grounding(objects).ground(formula, {}, True)


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
    def __init__(self, objects: Objects) -> None:
        self._objects = objects

    def ground(self, formula: f.Formula, binding: Mapping[str, str], positive: bool) -> Choice:
        match formula:
            case f.Atom() | f.Occurs() | f.Equals():
                return _condition(formula, binding, positive)
            case f.Not(operand):
                return self.ground(operand, binding, not positive)
            case f.And(operands) | f.Or(operands):
                parts = tuple([self.ground(operand, binding, positive) for operand in operands])
                return AllOf(parts) if isinstance(formula, f.And) == positive else AnyOf(parts)
            case f.Implies(premise, conclusion):
                return self.ground(f.Or((f.Not(premise), conclusion)), binding, positive)
            case f.ForAll(variable, body) | f.Exists(variable, body):
                parts = self._instances(variable, body, binding, positive)
                return AllOf(parts) if isinstance(formula, f.ForAll) == positive else AnyOf(parts)
            case f.Exactly(count, variable, body) if positive:
                return Choose(count, self._instances(variable, body, binding, True))
            case f.ForPairs() if positive:
                return self._pairing(formula, binding)
            case f.Then(steps) if positive:
                return AllOf(tuple([self.ground(step, binding, True) for step in steps]))
            case _:
                negated = "" if positive else "a negated "
                raise InputError(f"{negated}{type(formula).__name__} leaves no finite choice of conditions")

    def _instances(
        self, variable: f.Variable, body: f.Formula, binding: Mapping[str, str], positive: bool
    ) -> tuple[Choice, ...]:
        values = self._objects(variable.category)
        return tuple([self.ground(body, {**binding, variable.name: value}, positive) for value in values])

    def _pairing(self, formula: f.ForPairs, binding: Mapping[str, str]) -> Pairing[Choice]:
        first, second, body = formula.first, formula.second, formula.body
        rows, columns = self._objects(first.category), self._objects(second.category)

        def cell(x: str, y: str) -> Choice | None:
            return None if x == y else self.ground(body, {**binding, first.name: x, second.name: y}, True)

        count = min(len(rows), len(columns)) if formula.count is None else formula.count
        return Pairing(count, tuple(tuple(cell(x, y) for y in columns) for x in rows))


def _condition(formula: f.Atom | f.Occurs | f.Equals, binding: Mapping[str, str], positive: bool) -> Choice:
    match formula:
        case f.Equals(left, right):
            true = value_of(left, binding) == value_of(right, binding)
            return AllOf(()) if true == positive else AnyOf(())
        case f.Atom(predicate, arguments):
            literal: f.Atom | f.Occurs = f.Atom(predicate, tuple([value_of(t, binding) for t in arguments]))
        case f.Occurs(action, arguments):
            literal = f.Occurs(action, tuple([value_of(t, binding) for t in arguments]))
    return Leaf(literal if positive else f.Not(literal))


def value_of(term: f.Term, binding: Mapping[str, str]) -> f.Constant:
    """The object that a term denotes when variables have these values.

    Raises:
        InputError: it is a variable without a value.
    """
    if isinstance(term, f.Constant):
        return term
    if term.name not in binding:
        raise InputError(f"variable {term.name} is not bound by a quantifier")
    return f.Constant(binding[term.name])
