"""Walking over formulas: their parts, size, variables and kind. Nothing here recurses."""

from __future__ import annotations

from collections.abc import Iterator

from typing_extensions import assert_never

from eai.logic.formula import (
    Always,
    And,
    Atom,
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
    Then,
    Until,
)

MAX_DEPTH = 100
"""The deepest nesting that the syntaxes accept.

Python compares, hashes and shows nested values recursively; up to this depth all of that is safe. The
deepest formula in the two data sets has 6 levels.
"""


def children(formula: Formula) -> tuple[Formula, ...]:
    """The immediate parts of a formula, left to right."""
    match formula:
        case Atom() | Occurs() | Equals():
            return ()
        case And(parts) | Or(parts) | Then(parts):
            return parts
        case Not(operand) | Next(operand) | Eventually(operand) | Always(operand):
            return (operand,)
        case ForAll(_, body) | Exists(_, body) | Exactly(_, _, body) | ForPairs(_, _, body):
            return (body,)
        case Implies(left, right) | Until(left, right):
            return (left, right)
        case _:
            assert_never(formula)


def walk(formula: Formula) -> Iterator[Formula]:
    """The formula and all its parts, each before its own parts, left to right."""
    pending = [formula]
    while pending:
        current = pending.pop()
        yield current
        pending.extend(reversed(children(current)))


def depth(formula: Formula) -> int:
    """The number of levels; an atom has 1."""
    deepest = 0
    level = [formula]
    while level:
        deepest += 1
        level = [part for current in level for part in children(current)]
    return deepest


def temporal_parts(formula: Formula) -> frozenset[int]:
    """The ``id`` of every part, the formula included, that speaks of more than one position."""
    found: set[int] = set()
    for part in reversed(list(walk(formula))):
        if isinstance(part, (Then, Next, Eventually, Always, Until)) or any(
            id(child) in found for child in children(part)
        ):
            found.add(id(part))
    return frozenset(found)


def lasting_parts(formula: Formula) -> frozenset[int]:
    """The ``id`` of every part, the formula included, that stays true when the trajectory goes on.

    Sufficient, not necessary: a negation is lasting only if it speaks of one position.
    """
    temporal = temporal_parts(formula)
    found: set[int] = set()
    for part in reversed(list(walk(formula))):
        if (
            id(part) not in temporal
            or (
                not isinstance(part, (Not, Implies, Exactly, Always, Then))
                and all(id(child) in found for child in children(part))
            )
            or (isinstance(part, Then) and (not part.parts or id(part.parts[-1]) in found))
        ):
            found.add(id(part))
    return frozenset(found)


def is_state_formula(formula: Formula) -> bool:
    """Whether the formula speaks of one position only, that is, has no temporal operator."""
    return not any(isinstance(part, (Then, Next, Eventually, Always, Until)) for part in walk(formula))
