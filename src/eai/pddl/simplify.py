"""Connectives that leave out what is plain: true and false parts, double negations, junctions of one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from eai.logic.formula import (
    FALSE,
    TRUE,
    And,
    Atom,
    Constant,
    Equals,
    Exists,
    ForAll,
    Formula,
    Implies,
    Not,
    Or,
    Term,
    Variable,
)


def conjunction(parts: Iterable[Formula]) -> Formula:
    """All parts hold, each written once; false where one part denies another."""
    found = _flat(parts, And)
    if any(part == FALSE or negation(part) in found for part in found):
        return FALSE
    kept = tuple(part for part in found if part != TRUE)
    return kept[0] if len(kept) == 1 else And(kept)


def disjunction(parts: Iterable[Formula]) -> Formula:
    """Some part holds, each written once; true where one part denies another."""
    found = _flat(parts, Or)
    if any(part == TRUE or negation(part) in found for part in found):
        return TRUE
    kept = tuple(part for part in found if part != FALSE)
    return kept[0] if len(kept) == 1 else Or(kept)


def negation(formula: Formula) -> Formula:
    """The formula does not hold."""
    if isinstance(formula, Not):
        return formula.operand
    if formula in (TRUE, FALSE):
        return FALSE if formula == TRUE else TRUE
    return Not(formula)


def equality(left: Term, right: Term) -> Formula:
    """The terms denote one object; constants of different names never do."""
    if left == right:
        return TRUE
    return FALSE if isinstance(left, Constant) and isinstance(right, Constant) else Equals(left, right)


def substitute(formula: Formula, terms: Mapping[str, Term]) -> Formula:
    """The formula with terms put for free variables.

    No quantifier in it may bind a variable that is among the terms or is replaced by them.
    """
    match formula:
        case Atom(predicate, arguments):
            return Atom(predicate, tuple([_put(term, terms) for term in arguments]))
        case Equals(left, right):
            return equality(_put(left, terms), _put(right, terms))
        case Not(operand):
            return negation(substitute(operand, terms))
        case And(operands):
            return conjunction([substitute(operand, terms) for operand in operands])
        case Or(operands):
            return disjunction([substitute(operand, terms) for operand in operands])
        case Implies(premise, conclusion):
            return Implies(substitute(premise, terms), substitute(conclusion, terms))
        case ForAll(variable, body) | Exists(variable, body):
            return type(formula)(variable, substitute(body, terms))
        case _:
            raise ValueError(f"{type(formula).__name__} has no PDDL form")


def _put(term: Term, terms: Mapping[str, Term]) -> Term:
    return terms.get(term.name, term) if isinstance(term, Variable) else term


def _flat(parts: Iterable[Formula], connective: type[And] | type[Or]) -> tuple[Formula, ...]:
    found: dict[Formula, None] = {}
    for part in parts:
        found |= dict.fromkeys(part.operands if isinstance(part, connective) else (part,))
    return tuple(found)
