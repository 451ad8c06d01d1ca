"""Connectives that leave out what is plain: true and false parts, double negations, junctions of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import eai.logic.formula as f


def conjunction(parts: Iterable[f.Formula]) -> f.Formula:
    """All parts hold, each written once; false where one part denies another."""
    return _junction(f.And, parts, nothing=f.TRUE, decisive=f.FALSE)


def disjunction(parts: Iterable[f.Formula]) -> f.Formula:
    """Some part holds, each written once; true where one part denies another."""
    return _junction(f.Or, parts, nothing=f.FALSE, decisive=f.TRUE)


def negation(formula: f.Formula) -> f.Formula:
    """The formula does not hold."""
    if isinstance(formula, f.Not):
        return formula.operand
    if formula in (f.TRUE, f.FALSE):
        return f.FALSE if formula == f.TRUE else f.TRUE
    return f.Not(formula)


def equality(left: f.Term, right: f.Term) -> f.Formula:
    """The terms denote one object; constants of different names never do."""
    if left == right:
        return f.TRUE
    return (
        f.FALSE if isinstance(left, f.Constant) and isinstance(right, f.Constant) else f.Equals(left, right)
    )


def substitute(formula: f.Formula, terms: Mapping[str, f.Term]) -> f.Formula:
    """The formula with terms put for free variables.

    No quantifier in it may bind a variable that is among the terms or is replaced by them.
    """
    match formula:
        case f.Atom(predicate, arguments):
            return f.Atom(predicate, tuple([_put(term, terms) for term in arguments]))
        case f.Equals(left, right):
            return equality(_put(left, terms), _put(right, terms))
        case f.Not(operand):
            return negation(substitute(operand, terms))
        case f.And(operands):
            return conjunction([substitute(operand, terms) for operand in operands])
        case f.Or(operands):
            return disjunction([substitute(operand, terms) for operand in operands])
        case f.Implies(premise, conclusion):
            return f.Implies(substitute(premise, terms), substitute(conclusion, terms))
        case f.ForAll(variable, body) | f.Exists(variable, body):
            return type(formula)(variable, substitute(body, terms))
        case _:
            raise ValueError(f"{type(formula).__name__} has no PDDL form")


def _put(term: f.Term, terms: Mapping[str, f.Term]) -> f.Term:
    return terms.get(term.name, term) if isinstance(term, f.Variable) else term


def _junction(
    connective: type[f.And] | type[f.Or],
    parts: Iterable[f.Formula],
    *,
    nothing: f.Formula,
    decisive: f.Formula,
) -> f.Formula:
    """The parts connected: ``nothing`` is left out, ``decisive`` is the whole, and so are two opposites."""
    found: dict[f.Formula, None] = {}
    for part in parts:
        found |= dict.fromkeys(part.operands if isinstance(part, connective) else (part,))
    if any(part == decisive or negation(part) in found for part in found):
        return decisive
    kept = tuple(part for part in found if part != nothing)
    return kept[0] if len(kept) == 1 else connective(kept)
