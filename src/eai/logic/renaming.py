"""Formulas that say the same under other names, of objects or of variables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import chain, count

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.logic.traversal import objects


def rename_objects(formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
    """The formula in which every object that has a new name goes by it. Variables and categories stay."""
    return _renamed(formula, {f.Constant(old): f.Constant(new) for old, new in names.items()}, None)


def rename_variables(formula: f.Formula) -> f.Formula:
    """The formula in which the bound variables are x, y, z, x1, x2, ... in the order of their quantifiers.

    What is the name of an object in it is left out.
    """
    taken = objects(formula)
    fresh = (name for name in chain("xyz", (f"x{number}" for number in count(1))) if name not in taken)
    return _renamed(formula, {}, fresh)


def _renamed(formula: f.Formula, terms: Mapping[f.Term, f.Term], fresh: Iterator[str] | None) -> f.Formula:
    """The formula with other terms; ``fresh`` gives the names of bound variables, which stay where None."""
    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments):
            return replace(formula, arguments=tuple([_term(term, terms) for term in arguments]))
        case f.Equals(left, right):
            return f.Equals(_term(left, terms), _term(right, terms))
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return replace(formula, operand=_renamed(operand, terms, fresh))
        case f.And(operands) | f.Or(operands):
            return replace(formula, operands=tuple([_renamed(part, terms, fresh) for part in operands]))
        case f.Then(parts):
            return f.Then(tuple([_renamed(part, terms, fresh) for part in parts]))
        case f.Implies(premise, conclusion):
            return f.Implies(_renamed(premise, terms, fresh), _renamed(conclusion, terms, fresh))
        case f.Until(left, right):
            return f.Until(_renamed(left, terms, fresh), _renamed(right, terms, fresh))
        case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
            bound = _bound(variable, fresh)
            inner = {**terms, f.Variable(variable.name): f.Variable(bound.name)}
            return replace(formula, variable=bound, body=_renamed(body, inner, fresh))
        case f.ForPairs(first, second, body):
            one, other = _bound(first, fresh), _bound(second, fresh)
            inner = {
                **terms,
                f.Variable(first.name): f.Variable(one.name),
                f.Variable(second.name): f.Variable(other.name),
            }
            return replace(formula, first=one, second=other, body=_renamed(body, inner, fresh))
        case _:
            assert_never(formula)


def _term(term: f.Term, terms: Mapping[f.Term, f.Term]) -> f.Term:
    """What stands for a term; a variable goes by its name, with or without its category."""
    found = terms.get(f.Variable(term.name) if isinstance(term, f.Variable) else term)
    return term if found is None or found.name == term.name else found


def _bound(variable: f.Variable, fresh: Iterator[str] | None) -> f.Variable:
    return variable if fresh is None else replace(variable, name=next(fresh))
