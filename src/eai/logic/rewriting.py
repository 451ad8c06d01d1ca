"""Rewrite formulas: replace their leaves or names, or move negations to the leaves."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import chain, count
from typing import TypeVar

import eai.logic.formula as f
from eai.base.errors import InputError
from eai.logic.traversal import find_object_names, get_bound_variables, is_state_formula, map_subformulas

L = TypeVar("L", bound=f.Leaf)


def map_terms(leaf: L, change: Callable[[f.Term], f.Term]) -> L:
    """Return a leaf (atom, action or equation) in which ``change(term)`` replaces each term."""
    if isinstance(leaf, f.Equals):
        return replace(leaf, left=change(leaf.left), right=change(leaf.right))
    return replace(leaf, arguments=tuple([change(term) for term in leaf.arguments]))


def map_leaves(formula: f.Formula, change: Callable[[f.Leaf], f.Formula]) -> f.Formula:
    """Return a formula whose leaves are replaced by ``change(leaf)``."""
    if isinstance(formula, (f.Atom, f.Occurs, f.Equals)):
        return change(formula)
    return map_subformulas(formula, lambda part: map_leaves(part, change))


def rewrite_leaves(
    formula: f.Formula,
    change: Callable[[f.Leaf, frozenset[str]], f.Formula],
    bound: frozenset[str] = frozenset(),
) -> f.Formula:
    """Return a formula whose leaves are replaced by ``change(leaf, bound)``.

    ``bound`` is the set of the names of the variables that quantifiers around the leaf bind.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """
    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return change(formula, bound)
        case f.Next() | f.Eventually() | f.Always() | f.Until():
            raise InputError(f"{type(formula).__name__} is not an operator of goals and subgoals: use `then`")
    inner = bound.union([variable.name for variable in get_bound_variables(formula)])
    return map_subformulas(formula, lambda part: rewrite_leaves(part, change, inner))


def rewrite_state_subformulas(formula: f.Formula, change: Callable[[f.Formula], f.Formula]) -> f.Formula:
    """Replace each largest subformula without temporal operators by ``change(subformula)``.

    Return the new formula.

    Raises:
        InputError: a quantifier of the formula contains a temporal operator.
    """
    if is_state_formula(formula):
        return change(formula)
    if isinstance(formula, (f.ForAll, f.Exists, f.Exactly, f.ForPairs)):
        raise InputError("a temporal operator stands inside a quantifier: put it outside")
    return map_subformulas(formula, lambda part: rewrite_state_subformulas(part, change))


def substitute_terms(formula: f.Formula, values: Mapping[f.Term, f.Term]) -> f.Formula:
    """Return a formula whose constants and free variables are replaced by the terms in a mapping.

    Raises:
        InputError: the formula has a temporal operator other than `Then`.
    """
    return rewrite_leaves(
        formula,
        lambda leaf, bound: map_terms(
            leaf, lambda term: term if term.name in bound else values.get(term, term)
        ),
    )


def push_negations_inwards(formula: f.Formula, *, negated: bool = False) -> f.Formula:
    """Return a formula equivalent to a formula, or to its negation, with negations only at the leaves.

    The result has no implications, either. Negations of counting quantifiers and of temporal operators stay
    in place.
    """
    match formula:
        case f.Not(operand):
            return push_negations_inwards(operand, negated=not negated)
        case f.And(parts) | f.Or(parts):
            kind = f.And if isinstance(formula, f.And) != negated else f.Or
            return kind(tuple([push_negations_inwards(part, negated=negated) for part in parts]))
        case f.Implies(premise, conclusion):
            either = f.Or((f.Not(premise), conclusion))
            return push_negations_inwards(either, negated=negated)
        case f.ForAll(variable, body) | f.Exists(variable, body):
            quantifier = f.ForAll if isinstance(formula, f.ForAll) != negated else f.Exists
            return quantifier(variable, push_negations_inwards(body, negated=negated))
        case f.Then(parts) if not negated:
            return f.Then(tuple([push_negations_inwards(part) for part in parts]))
        case _:
            return f.Not(formula) if negated else formula


def rename_objects(formula: f.Formula, names: Mapping[str, str]) -> f.Formula:
    """Return a formula with its objects renamed. Variables and categories keep their names."""

    def rename_object(term: f.Term) -> f.Term:
        new = names.get(term.name, term.name) if isinstance(term, f.Constant) else term.name
        return term if new == term.name else f.Constant(new)

    return map_leaves(formula, lambda leaf: map_terms(leaf, rename_object))


def standardize_variable_names(formula: f.Formula) -> f.Formula:
    """Return a formula with bound variables named x, y, z, x1, x2, ... in the order of their quantifiers.

    Variables do not get names that objects in the formula have.
    """
    taken = find_object_names(formula)
    fresh = filter(lambda name: name not in taken, chain("xyz", map("x{}".format, count(1))))
    return _rename_bound_and_free(formula, {}, fresh)


def _rename_bound_and_free(formula: f.Formula, names: Mapping[str, str], fresh: Iterator[str]) -> f.Formula:
    """Rename free variables by the mapping ``names``, and bound variables by the next names in ``fresh``."""

    def rename_variable(term: f.Term) -> f.Term:
        new = names.get(term.name, term.name) if isinstance(term, f.Variable) else term.name
        return term if new == term.name else f.Variable(new)

    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return map_terms(formula, rename_variable)
        case f.ForAll(variable, body) | f.Exists(variable, body) | f.Exactly(_, variable, body):
            one = replace(variable, name=next(fresh))
            inner = {**names, variable.name: one.name}
            return replace(formula, variable=one, body=_rename_bound_and_free(body, inner, fresh))
        case f.ForPairs(first, second, body):
            one, other = replace(first, name=next(fresh)), replace(second, name=next(fresh))
            inner = {**names, first.name: one.name, second.name: other.name}
            return replace(formula, first=one, second=other, body=_rename_bound_and_free(body, inner, fresh))
        case _:
            return map_subformulas(formula, lambda part: _rename_bound_and_free(part, names, fresh))
