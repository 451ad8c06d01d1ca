"""The one formula type: goals, subgoals, conditions, checks and derived predicates are all of it.

A formula is a frozen value without behaviour of its own. Concrete syntaxes (LTL text, BDDL, PDDL) read and
print it, evaluators give it a meaning. State formulas speak of one state; the temporal operators at the end
of the file speak of finite traces (paper, section "LTL representation of goals").

Python's ``&``, ``|`` and ``~`` build conjunction, disjunction and negation, so that a domain reads like
logic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable; where it is bound by a quantifier, ``category`` restricts what it ranges over.

    ``category`` is None for "every object". It is part of the binding occurrence only: occurrences in a body
    are written without it.
    """

    name: str
    category: str | None = None


@dataclass(frozen=True, slots=True)
class Constant:
    """An object, by the name that the syntax at hand gives it (``sofa.352``, ``rag_51``, ``char``)."""

    name: str


Term: TypeAlias = Variable | Constant


class _Connectives:
    """Infix notation for the three Boolean connectives."""

    __slots__ = ()

    def __and__(self: Formula, other: Formula) -> And:  # type: ignore[misc]
        return And((*operands(self, And), *operands(other, And)))

    def __or__(self: Formula, other: Formula) -> Or:  # type: ignore[misc]
        return Or((*operands(self, Or), *operands(other, Or)))

    def __invert__(self: Formula) -> Not:  # type: ignore[misc]
        return Not(self)


@dataclass(frozen=True, slots=True)
class Atom(_Connectives):
    """A proposition over a state: a predicate applied to objects."""

    predicate: str
    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Occurs(_Connectives):
    """A proposition over actions: the action is taken, with these objects, at this position."""

    action: str
    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Equals(_Connectives):
    """Two terms denote the same object."""

    left: Term
    right: Term


@dataclass(frozen=True, slots=True)
class Not(_Connectives):
    """Negation."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class And(_Connectives):
    """Conjunction of any number of formulas; the empty one is true."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or(_Connectives):
    """Disjunction of any number of formulas; the empty one is false."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Implies(_Connectives):
    """Material implication."""

    premise: Formula
    conclusion: Formula


@dataclass(frozen=True, slots=True)
class ForAll(_Connectives):
    """The body holds for every value of the variable."""

    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class Exists(_Connectives):
    """The body holds for at least one value of the variable."""

    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class Exactly(_Connectives):
    """The body holds for exactly ``count`` values of the variable (the paper's and BDDL's ``forn``)."""

    count: int
    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class ForPairs(_Connectives):
    """The body holds along a pairing of all objects of the smaller category (BDDL's ``forpairs``).

    ``count`` None pairs up as many as the smaller category has; a number asks for that many pairs
    (BDDL's ``fornpairs``).
    """

    first: Variable
    second: Variable
    body: Formula
    count: int | None = None


@dataclass(frozen=True, slots=True)
class Then(_Connectives):
    """The parts hold one after the other on consecutive segments (the paper's ``then``)."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Next(_Connectives):
    """The operand holds at the next position, and there is one (strong next)."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Eventually(_Connectives):
    """The operand holds at this or some later position."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Always(_Connectives):
    """The operand holds at this and every later position."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Until(_Connectives):
    """``right`` holds at this or some later position, and ``left`` at every position before that one."""

    left: Formula
    right: Formula


Leaf: TypeAlias = Atom | Occurs | Equals
"""A formula that has no parts."""

Quantified: TypeAlias = ForAll | Exists | Exactly | ForPairs
"""A formula that binds variables."""

Temporal: TypeAlias = Then | Next | Eventually | Always | Until
"""A formula about more than one state."""

Formula: TypeAlias = Leaf | Not | And | Or | Implies | Quantified | Temporal

TRUE = And(())
FALSE = Or(())


def operands(formula: Formula, connective: type[And] | type[Or]) -> tuple[Formula, ...]:
    """The operands of a formula that already is of this connective, else the formula alone."""
    return formula.operands if isinstance(formula, connective) else (formula,)
