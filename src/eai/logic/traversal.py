"""Functions that walk over formulas: they find subformulas, variables, objects and predicates.

They also find the subformulas whose truth is monotone in the length of a trace. No function recurses.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar, get_args

from typing_extensions import assert_never

import eai.logic.formula as f

T = TypeVar("T")
_TEMPORAL = get_args(f.Temporal)

MAX_FORMULA_DEPTH = 100
"""Maximum nesting depth of formulas that the parsers accept.

Python compares, hashes and shows nested values recursively, which is safe up to this depth. The deepest
formula in the two data sets has 6 levels.
"""

MAX_COUNT_DIGITS = 9
"""Maximum number of digits of the count in a counting quantifier, such as ``forn 2``."""


def get_subformulas(formula: f.Formula) -> tuple[f.Formula, ...]:
    """Return the immediate subformulas of a formula, left to right."""
    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return ()
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return parts
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return (operand,)
        case f.ForAll(_, body) | f.Exists(_, body) | f.Exactly(_, _, body) | f.ForPairs(_, _, body):
            return (body,)
        case f.Implies(left, right) | f.Until(left, right):
            return (left, right)
        case _:
            assert_never(formula)


def get_bound_variables(formula: f.Formula) -> tuple[f.Variable, ...]:
    """Return the variables that a quantifier binds; () for other formulas."""
    match formula:
        case f.ForAll(variable) | f.Exists(variable) | f.Exactly(_, variable):
            return (variable,)
        case f.ForPairs(first, second):
            return first, second
        case _:
            return ()


def get_terms(formula: f.Formula) -> tuple[f.Term, ...]:
    """Return the terms of an atom, an action or an equation, left to right; () for other formulas."""
    match formula:
        case f.Atom(_, arguments) | f.Occurs(_, arguments):
            return arguments
        case f.Equals(left, right):
            return left, right
        case _:
            return ()


def map_subformulas(formula: f.Formula, change: Callable[[f.Formula], f.Formula]) -> f.Formula:
    """Return a formula whose immediate subformulas are replaced by ``change(subformula)``, left to right."""
    match formula:
        case f.Atom() | f.Occurs() | f.Equals():
            return formula
        case f.And(parts) | f.Or(parts) | f.Then(parts):
            return type(formula)(tuple([change(part) for part in parts]))
        case f.Not(operand) | f.Next(operand) | f.Eventually(operand) | f.Always(operand):
            return type(formula)(change(operand))
        case f.ForAll(_, body) | f.Exists(_, body) | f.Exactly(_, _, body) | f.ForPairs(_, _, body):
            return replace(formula, body=change(body))
        case f.Implies(left, right) | f.Until(left, right):
            return type(formula)(change(left), change(right))
        case _:
            assert_never(formula)


def wrap_in_quantifiers(
    make_quantifier: Callable[[f.Variable, T], T], variables: Sequence[f.Variable], body: T
) -> T:
    """Put one quantifier for each variable around a formula or an effect; the first variable is outermost."""
    for variable in reversed(variables):
        body = make_quantifier(variable, body)
    return body


def walk_subformulas(formula: f.Formula) -> Iterator[f.Formula]:
    """Yield a formula and all its subformulas, left to right, each before its own subformulas."""
    pending = [formula]
    while pending:
        current = pending.pop()
        yield current
        pending.extend(reversed(get_subformulas(current)))


def find_object_names(formula: f.Formula) -> tuple[str, ...]:
    """Return the names of the objects in a formula, each once, left to right."""
    terms = (term for part in walk_subformulas(formula) for term in get_terms(part))
    return tuple(dict.fromkeys([term.name for term in terms if isinstance(term, f.Constant)]))


def find_predicates(*formulas: f.Formula) -> tuple[str, ...]:
    """Return the predicates in formulas, each once, left to right."""
    parts = (part for formula in formulas for part in walk_subformulas(formula))
    return tuple(dict.fromkeys([part.predicate for part in parts if isinstance(part, f.Atom)]))


def find_free_variables(formula: f.Formula) -> frozenset[str]:
    """Return the names of the variables that no quantifier of the formula binds."""
    names: set[str] = set()
    pending: list[tuple[f.Formula, frozenset[str]]] = [(formula, frozenset())]
    while pending:
        part, bound = pending.pop()
        if isinstance(part, (f.Atom, f.Occurs, f.Equals)):
            names |= {term.name for term in get_terms(part) if isinstance(term, f.Variable)} - bound
        else:
            inner = bound.union([variable.name for variable in get_bound_variables(part)])
            pending += [(child, inner) for child in get_subformulas(part)]
    return frozenset(names)


def find_temporal_subformula_ids(formula: f.Formula) -> frozenset[int]:
    """Return Python's ``id`` of every subformula (also the formula itself) that has a temporal operator."""
    ids: set[int] = set()
    for part in reversed(list(walk_subformulas(formula))):
        if isinstance(part, _TEMPORAL) or not ids.isdisjoint(map(id, get_subformulas(part))):
            ids.add(id(part))
    return frozenset(ids)


class _SubformulaIdsMonotoneInTraceLength(NamedTuple):
    """The ``id`` of each subformula whose truth on a segment of a trace is monotone in the segment's length.

    A segment is a sequence of consecutive states. It grows and shrinks at its end.
    """

    ids_staying_true_when_longer: frozenset[int]
    """Python's ``id`` of each subformula that, if true on a segment of a trace, is true on longer segments.

    The longer segments have the same start.
    """
    ids_staying_true_when_shorter: frozenset[int]
    """Python's ``id`` of each temporal subformula that, if true on a segment, is true on shorter segments.

    The shorter segments have the same start.
    """


def find_subformula_ids_monotone_in_trace_length(formula: f.Formula) -> _SubformulaIdsMonotoneInTraceLength:
    """Find subformulas that stay true if a segment of a trace becomes longer, or if it becomes shorter.

    A segment is a sequence of consecutive states. Its end changes, but its start stays. Only operators are
    examined, not atoms, so some of these subformulas may be missed.
    """
    temporal = find_temporal_subformula_ids(formula)
    ids_staying_true_when_longer: set[int] = set()
    ids_staying_true_when_shorter: set[int] = set()
    for part in reversed(list(walk_subformulas(formula))):
        if id(part) not in temporal or _stays_true_on_longer_trace(
            part, ids_staying_true_when_longer, ids_staying_true_when_shorter
        ):
            ids_staying_true_when_longer.add(id(part))
        elif _stays_true_on_shorter_trace(
            part, temporal, ids_staying_true_when_longer, ids_staying_true_when_shorter
        ):
            ids_staying_true_when_shorter.add(id(part))
    return _SubformulaIdsMonotoneInTraceLength(
        frozenset(ids_staying_true_when_longer), frozenset(ids_staying_true_when_shorter)
    )


def _stays_true_on_longer_trace(
    subformula: f.Formula,
    ids_staying_true_when_longer: Container[int],
    ids_staying_true_when_shorter: Container[int],
) -> bool:
    match subformula:
        case f.Not(operand):
            return id(operand) in ids_staying_true_when_shorter
        case f.Then(parts):
            return not parts or id(parts[-1]) in ids_staying_true_when_longer
        case f.Implies() | f.Exactly() | f.Always():
            return False
        case _:
            return all(id(child) in ids_staying_true_when_longer for child in get_subformulas(subformula))


def _stays_true_on_shorter_trace(
    subformula: f.Formula,
    temporal_ids: Container[int],
    ids_staying_true_when_longer: Container[int],
    ids_staying_true_when_shorter: Container[int],
) -> bool:
    match subformula:
        case f.Not(operand):
            return id(operand) in ids_staying_true_when_longer
        case f.Always(operand):
            return id(operand) not in temporal_ids or id(operand) in ids_staying_true_when_shorter
        case f.And() | f.Or() | f.ForAll() | f.Exists():
            return all(id(child) in ids_staying_true_when_shorter for child in get_subformulas(subformula))
        case _:
            return False


def is_state_formula(formula: f.Formula) -> bool:
    """Whether a formula has no temporal operator, and is therefore about one state."""
    return not any(isinstance(part, _TEMPORAL) for part in walk_subformulas(formula))
