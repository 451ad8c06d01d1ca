"""Formulas about the same objects under other names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from typing_extensions import assert_never

from eai.logic.formula import (
    Always,
    And,
    Atom,
    Constant,
    Equals,
    Eventually,
    Exactly,
    Exists,
    ForAll,
    Formula,
    ForPairs,
    Implies,
    Next,
    Not,
    Occurs,
    Or,
    Term,
    Then,
    Until,
)


def rename_objects(formula: Formula, names: Mapping[str, str]) -> Formula:
    """The formula in which every object that has a new name goes by it. Variables and categories stay."""
    match formula:
        case Atom(_, arguments) | Occurs(_, arguments):
            return replace(formula, arguments=tuple(_renamed(term, names) for term in arguments))
        case Equals(left, right):
            return Equals(_renamed(left, names), _renamed(right, names))
        case Not(operand) | Next(operand) | Eventually(operand) | Always(operand):
            return replace(formula, operand=rename_objects(operand, names))
        case And(operands) | Or(operands):
            return replace(formula, operands=tuple(rename_objects(part, names) for part in operands))
        case Then(parts):
            return Then(tuple(rename_objects(part, names) for part in parts))
        case Implies(premise, conclusion):
            return Implies(rename_objects(premise, names), rename_objects(conclusion, names))
        case Until(left, right):
            return Until(rename_objects(left, names), rename_objects(right, names))
        case ForAll(_, body) | Exists(_, body) | Exactly(_, _, body) | ForPairs(_, _, body):
            return replace(formula, body=rename_objects(body, names))
        case _:
            assert_never(formula)


def _renamed(term: Term, names: Mapping[str, str]) -> Term:
    return Constant(names.get(term.name, term.name)) if isinstance(term, Constant) else term
