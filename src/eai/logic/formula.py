"""Formulas: one type for goals, subgoals, conditions, checks and derived predicates.

A formula is a frozen value without behaviour of its own. Other modules read and print formulas in concrete
syntaxes (LTL text, BDDL, PDDL), and evaluate them. State formulas are about one state. The temporal operators
at the end of this file are about finite traces (paper, section "LTL representation of goals").

Python's ``&``, ``|`` and ``~`` build conjunction, disjunction and negation, so that a domain reads
like logic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable. In a quantifier, ``category`` restricts its values; None allows every object.

    Where the variable occurs in the body of the quantifier, its category is None.
    """

    name: str
    category: str | None = None


@dataclass(frozen=True, slots=True)
class Constant:
    """An object, given by its name in the concrete syntax, such as ``sofa.352``, ``rag_51`` or ``char``."""

    name: str


Term: TypeAlias = Variable | Constant


class _InfixOperators:
    """Base class that gives formulas the infix operators ``&``, ``|`` and ``~``."""

    __slots__ = ()

    def __and__(self: Formula, other: Formula) -> And:  # type: ignore[misc]
        return And((*get_operands(self, And), *get_operands(other, And)))

    def __or__(self: Formula, other: Formula) -> Or:  # type: ignore[misc]
        return Or((*get_operands(self, Or), *get_operands(other, Or)))

    def __invert__(self: Formula) -> Not:  # type: ignore[misc]
        return Not(self)


@dataclass(frozen=True, slots=True)
class Atom(_InfixOperators):
    """A proposition over a state: a predicate applied to objects."""

    predicate: str
    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Occurs(_InfixOperators):
    """A proposition that is true at a position of a trace if this action is taken there on these objects."""

    action: str
    arguments: tuple[Term, ...] = ()


@dataclass(frozen=True, slots=True)
class Equals(_InfixOperators):
    """A formula that holds if two terms denote the same object."""

    left: Term
    right: Term


@dataclass(frozen=True, slots=True)
class Not(_InfixOperators):
    """The negation of a formula."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class And(_InfixOperators):
    """Conjunction of any number of formulas; without any formula it is true."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Or(_InfixOperators):
    """Disjunction of any number of formulas; without any formula it is false."""

    operands: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Implies(_InfixOperators):
    """Material implication."""

    premise: Formula
    conclusion: Formula


@dataclass(frozen=True, slots=True)
class ForAll(_InfixOperators):
    """A formula that holds if its body holds for every value of the variable."""

    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class Exists(_InfixOperators):
    """A formula that holds if its body holds for at least one value of the variable."""

    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class Exactly(_InfixOperators):
    """A formula that holds if its body holds for exactly ``count`` values of the variable.

    The paper and BDDL write it ``forn``.
    """

    count: int
    variable: Variable
    body: Formula


@dataclass(frozen=True, slots=True)
class ForPairs(_InfixOperators):
    """A formula that holds if objects of two categories can be matched in pairs for which the body holds.

    BDDL writes it ``forpairs``. If ``count`` is None, the matching must cover all objects of the smaller
    category. Otherwise it must have ``count`` pairs (BDDL's ``fornpairs``).
    """

    first: Variable
    second: Variable
    body: Formula
    count: int | None = None


@dataclass(frozen=True, slots=True)
class Then(_InfixOperators):
    """A formula whose parts hold in turn, on consecutive segments of the trace. It is written ``then``."""

    parts: tuple[Formula, ...]


@dataclass(frozen=True, slots=True)
class Next(_InfixOperators):
    """A formula that holds if a next position exists and its operand holds there (strong next)."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Eventually(_InfixOperators):
    """A formula that holds if its operand holds at this or some later position."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Always(_InfixOperators):
    """A formula that holds if its operand holds at this and every later position."""

    operand: Formula


@dataclass(frozen=True, slots=True)
class Until(_InfixOperators):
    """A formula that holds if ``right`` holds now or later, and ``left`` at every position before that."""

    left: Formula
    right: Formula


Leaf: TypeAlias = Atom | Occurs | Equals
"""Formula without subformulas."""

Quantified: TypeAlias = ForAll | Exists | Exactly | ForPairs
"""Formula that binds variables."""

Temporal: TypeAlias = Then | Next | Eventually | Always | Until
"""Formula about several positions of a trace."""

Formula: TypeAlias = Leaf | Not | And | Or | Implies | Quantified | Temporal

TRUE = And(())
FALSE = Or(())


def get_operands(formula: Formula, connective: type[And] | type[Or]) -> tuple[Formula, ...]:
    """Return the operands of a formula with the given connective; for another formula, the formula itself."""
    return formula.operands if isinstance(formula, connective) else (formula,)
