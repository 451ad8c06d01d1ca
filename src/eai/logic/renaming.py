"""Formulas about the same objects under other names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from typing_extensions import assert_never

import eai.logic.formula as f


def rename_objects(formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
    """The formula in which every object that has a new name goes by it. Variables and categories stay."""
    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments):
            return replace(formula, arguments=tuple(_renamed(term, names) for term in arguments))
        case f.Equals(left, right):
            return f.Equals(_renamed(left, names), _renamed(right, names))
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return replace(formula, operand=rename_objects(operand, names))
        case f.And(operands) | f.Or(operands):
            return replace(formula, operands=tuple(rename_objects(part, names) for part in operands))
        case f.Then(parts):
            return f.Then(tuple(rename_objects(part, names) for part in parts))
        case f.Implies(premise, conclusion):
            return f.Implies(rename_objects(premise, names), rename_objects(conclusion, names))
        case f.Until(left, right):
            return f.Until(rename_objects(left, names), rename_objects(right, names))
        case f.ForAll(_, body) | f.Exists(_, body) | f.Exactly(_, _, body) | f.ForPairs(_, _, body):
            return replace(formula, body=rename_objects(body, names))
        case _:
            assert_never(formula)


def _renamed(term: f.Term, names: Mapping[str, str]) -> f.Term:
    return f.Constant(names.get(term.name, term.name)) if isinstance(term, f.Constant) else term
