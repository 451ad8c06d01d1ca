"""Formulas made from formulas by replacing what stands at their leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

from eai.errors import InputError
from eai.logic.formula import (
    And,
    Atom,
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
)

Leaf: TypeAlias = Atom | Occurs | Equals


def rewrite(
    formula: Formula, change: Callable[[Leaf, frozenset[str]], Formula], bound: frozenset[str] = frozenset()
) -> Formula:
    """The formula with each leaf replaced by what ``change`` makes of it and of the variables bound there.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """
    match formula:
        case Atom() | Occurs() | Equals():
            return change(formula, bound)
        case And(parts) | Or(parts) | Then(parts):
            return type(formula)(tuple(rewrite(part, change, bound) for part in parts))
        case Not(operand):
            return Not(rewrite(operand, change, bound))
        case Implies(premise, conclusion):
            return Implies(rewrite(premise, change, bound), rewrite(conclusion, change, bound))
        case ForAll(variable, body) | Exists(variable, body) | Exactly(_, variable, body):
            return replace(formula, body=rewrite(body, change, bound | {variable.name}))
        case ForPairs(first, second, body):
            return replace(formula, body=rewrite(body, change, bound | {first.name, second.name}))
        case _:
            raise InputError(f"{type(formula).__name__} is not an operator of goals and subgoals")


def substitute(formula: Formula, values: Mapping[Term, Term]) -> Formula:
    """The formula with constants, and variables where they are free, replaced.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """

    def value(term: Term, bound: frozenset[str]) -> Term:
        return term if term.name in bound else values.get(term, term)

    def change(leaf: Leaf, bound: frozenset[str]) -> Formula:
        if isinstance(leaf, Equals):
            return Equals(value(leaf.left, bound), value(leaf.right, bound))
        return replace(leaf, arguments=tuple([value(term, bound) for term in leaf.arguments]))

    return rewrite(formula, change)
