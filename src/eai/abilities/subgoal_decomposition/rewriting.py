"""Formulas made from formulas by replacing what stands at their leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeAlias

import eai.logic.formula as f
from eai.errors import InputError
from eai.logic.traversal import is_state_formula

Leaf: TypeAlias = f.Atom | f.Occurs | f.Equals


def rewrite(
    formula: f.Formula,
    change: Callable[[Leaf, frozenset[str]], f.Formula],
    bound: frozenset[str] = frozenset(),
) -> f.Formula:
    """The formula with each leaf replaced by what ``change`` makes of it and of the variables bound there.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """
    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return change(formula, bound)
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return type(formula)(tuple(rewrite(part, change, bound) for part in parts))
        case f.Not(operand):
            return f.Not(rewrite(operand, change, bound))
        case f.Implies(premise, conclusion):
            return f.Implies(rewrite(premise, change, bound), rewrite(conclusion, change, bound))
        case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
            return replace(formula, body=rewrite(body, change, bound | {variable.name}))
        case f.ForPairs(first, second, body):
            return replace(formula, body=rewrite(body, change, bound | {first.name, second.name}))
        case _:
            raise InputError(f"{type(formula).__name__} is not an operator of goals and subgoals")


def rewrite_in_time(formula: f.Formula, change: Callable[[f.Formula], f.Formula]) -> f.Formula:
    """A formula of temporal logic in which each of the largest parts about one state is changed.

    Raises:
        InputError: it has a quantifier around a temporal operator.
    """
    if is_state_formula(formula):
        return change(formula)
    match formula:
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return type(formula)(rewrite_in_time(operand, change))
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return type(formula)(tuple([rewrite_in_time(part, change) for part in parts]))
        case f.Until(left, right) | f.Implies(left, right):
            return type(formula)(rewrite_in_time(left, change), rewrite_in_time(right, change))
        case _:
            raise InputError("expected temporal operators outside of quantifiers")


def substitute(formula: f.Formula, values: Mapping[f.Term, f.Term]) -> f.Formula:
    """The formula with constants, and variables where they are free, replaced.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """

    def value(term: f.Term, bound: frozenset[str]) -> f.Term:
        return term if term.name in bound else values.get(term, term)

    def change(leaf: Leaf, bound: frozenset[str]) -> f.Formula:
        if isinstance(leaf, f.Equals):
            return f.Equals(value(leaf.left, bound), value(leaf.right, bound))
        return replace(leaf, arguments=tuple([value(term, bound) for term in leaf.arguments]))

    return rewrite(formula, change)


def negation_normal(formula: f.Formula, *, negated: bool = False) -> f.Formula:
    """The formula, or its negation, with negations at the leaves only and without implications.

    Negations of counting quantifiers and of temporal operators stay where they are.
    """
    match formula:
        case f.Not(operand):
            return negation_normal(operand, negated=not negated)
        case f.And(parts) | f.Or(parts):
            kind = f.And if isinstance(formula, f.And) != negated else f.Or
            return kind(tuple([negation_normal(part, negated=negated) for part in parts]))
        case f.Implies(premise, conclusion):
            either = f.Or((f.Not(premise), conclusion))
            return negation_normal(either, negated=negated)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            quantifier = f.ForAll if isinstance(formula, f.ForAll) != negated else f.Exists
            return quantifier(variable, negation_normal(body, negated=negated))
        case f.Then(parts) if not negated:
            return f.Then(tuple([negation_normal(part) for part in parts]))
        case _:
            return f.Not(formula) if negated else formula
