"""Comparing operators with the gold ones, as the paper means it.

The unit is the clause: a part of the list that a condition or an effect is, or the whole of it where it is
no list. A clause is matched by an identical one, with all that is nested in it; the order of parts means
nothing. Names of variables mean nothing either: parameters are matched by the best of the pairings that agree
with their types, bound variables by their quantifiers.

Besides, literals are counted with partial credit, each as often as it stands there. Parts of lists are paired
so that as many literals as possible match (an assignment problem, level by level), so that one wrong literal
inside a nested list costs one literal and not the list.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import permutations
from typing import NamedTuple, TypeVar

from eai.logic.formula import And, Constant, Term, Variable
from eai.logic.matching import heaviest_pairs
from eai.pddl.clauses import (
    Bound,
    Clause,
    Denied,
    Guarded,
    Joined,
    Literal,
    canonical,
    condition_clause,
    effect_clause,
    literals,
    parts_of,
    write_clause,
)
from eai.pddl.match import LiteralMatch, OperatorMatch, SideMatch
from eai.pddl.model import NO_EFFECT, PddlAction, type_of

_T = TypeVar("_T")

MAX_PERMUTED = 5
"""Up to how many parameters all pairings are tried; above, only that by position."""

Renaming = Mapping[str, str]
"""The gold name of each variable of the answer; a variable without one matches nothing."""


class _Side(NamedTuple):
    """One side of both operators, and the clauses of the gold one as they compare."""

    ours: Clause
    theirs: Clause
    wanted: tuple[str, ...]


class _Found(NamedTuple):
    """The clauses of one side, as `SideMatch` has them."""

    matched: list[Clause]
    additional: list[Clause]
    missing: list[Clause]


def match_operators(predicted: PddlAction, gold: PddlAction) -> OperatorMatch:
    """Compare an operator of an answer with the gold operator of the same name."""
    names = {parameter.name: parameter.name for parameter in gold.parameters}
    trees = (
        (condition_clause(predicted.precondition), condition_clause(gold.precondition)),
        (effect_clause(predicted.effect), effect_clause(gold.effect)),
    )
    sides = [
        _Side(ours, theirs, tuple([canonical(part, names) for part in parts_of(theirs)]))
        for ours, theirs in trees
    ]
    renamings = _renamings(predicted, gold)
    wanted = sum(len(side.wanted) for side in sides)
    renaming, found = _best(sides, renamings, _match_clauses, lambda clauses: len(clauses.matched), wanted)
    precondition, effect = [SideMatch(*[tuple(map(write_clause, part)) for part in side]) for side in found]
    wanted = sum(_size(side.theirs) for side in sides)
    _, matched = _best(sides, renamings, _match_side_literals, int, wanted)
    of_precondition, of_effect = [
        LiteralMatch(number, _size(side.ours) - number, _size(side.theirs) - number)
        for number, side in zip(matched, sides, strict=True)
    ]
    renamed = tuple([(ours, theirs) for ours, theirs in renaming.items() if ours != theirs])
    return OperatorMatch(precondition, effect, of_precondition, of_effect, renamed)


def missing_operator(gold: PddlAction) -> OperatorMatch:
    """The comparison with an operator that the answer does not have, or that cannot be read."""
    return match_operators(PddlAction(gold.name, (), And(()), NO_EFFECT), gold)


def _best(
    sides: Sequence[_Side],
    renamings: Iterable[Renaming],
    match: Callable[[_Side, Renaming], _T],
    number: Callable[[_T], int],
    wanted: int,
) -> tuple[Renaming, list[_T]]:
    """The first of the renamings with which most is found, and what is found on each side with it."""
    best: tuple[Renaming, list[_T]] = ({}, [])
    most = -1
    for renaming in renamings:
        found = [match(side, renaming) for side in sides]
        total = sum(map(number, found))
        if total > most:
            best, most = (renaming, found), total
        if most == wanted:
            break
    return best


def _match_clauses(side: _Side, renaming: Renaming) -> _Found:
    """The clauses of one side, each gold one paired with an identical one of the answer."""
    left = [(canonical(part, renaming), part) for part in _clauses(side.ours, side.theirs)]
    found = _Found([], [], [])
    for part, same in zip(parts_of(side.theirs), side.wanted, strict=True):
        partner = next(filter(lambda own: own[0] == same, left), None)
        if partner is None:
            found.missing.append(part)
        else:
            found.matched.append(part)
            left.remove(partner)
    found.additional.extend(part for _, part in left)
    return found


def _clauses(ours: Clause, theirs: Clause) -> tuple[Clause, ...]:
    """The clauses of an answer; beside a gold list with the other connective its list is a single one."""
    if isinstance(ours, Joined) and isinstance(theirs, Joined) and ours.parts and theirs.parts:
        return ours.parts if ours.connective is theirs.connective else (ours,)
    return parts_of(ours)


def _renamings(predicted: PddlAction, gold: PddlAction) -> list[Renaming]:
    """The pairings of parameters that agree with most types, that by position first."""
    ours, theirs = predicted.parameters, gold.parameters
    size = max(len(ours), len(theirs))
    orders = permutations(range(size)) if size <= MAX_PERMUTED else iter([tuple(range(size))])
    candidates = []
    for order in orders:
        pairs = [(ours[i], theirs[j]) for i, j in enumerate(order) if i < len(ours) and j < len(theirs)]
        agreeing = sum(type_of(a) == type_of(b) for a, b in pairs)
        candidates.append((agreeing, {a.name: b.name for a, b in pairs}))
    most = max(agreeing for agreeing, _ in candidates)
    return [renaming for agreeing, renaming in candidates if agreeing == most]


def _match_side_literals(side: _Side, renaming: Renaming) -> int:
    return _match_literals(side.ours, side.theirs, renaming)


def _match_literals(ours: Clause, theirs: Clause, renaming: Renaming) -> int:
    """How many literals find a partner when one tree is laid upon the other as well as possible."""
    match ours, theirs:
        case Literal(), Literal():
            return int(_same(ours, theirs, renaming))
        case Denied(a), Denied(b):
            return _match_literals(a, b, renaming)
        case Bound(scope, name, category, part), Bound() if (scope, category) == (theirs.scope, theirs.type):
            return _match_literals(part, theirs.part, {**renaming, name: theirs.name})
        case Guarded(), Guarded():
            guards = _match_literals(ours.guard, theirs.guard, renaming)
            return guards + _match_literals(ours.part, theirs.part, renaming)
        case Joined(), Joined() if ours.connective is not theirs.connective:
            return _match_unlike(ours, theirs, renaming)
        case (Joined(), _) | (_, Joined()):
            grid = [[_match_literals(a, b, renaming) for b in parts_of(theirs)] for a in parts_of(ours)]
            return sum(grid[row][column] for row, column in heaviest_pairs(grid))
        case _:
            return 0


def _match_unlike(ours: Joined, theirs: Joined, renaming: Renaming) -> int:
    """A conjunction and a disjunction match only as far as one of them is a part of the other."""
    inside = [_match_literals(part, theirs, renaming) for part in ours.parts if isinstance(part, Joined)]
    around = [_match_literals(ours, part, renaming) for part in theirs.parts if isinstance(part, Joined)]
    return max([*inside, *around], default=0)


def _size(clause: Clause) -> int:
    return sum(1 for _ in literals(clause))


def _same(ours: Literal, theirs: Literal, renaming: Renaming) -> bool:
    return (
        ours.predicate == theirs.predicate
        and ours.positive == theirs.positive
        and len(ours.arguments) == len(theirs.arguments)
        and all(_agree(a, b, renaming) for a, b in zip(ours.arguments, theirs.arguments, strict=True))
    )


def _agree(ours: Term, theirs: Term, renaming: Renaming) -> bool:
    match ours, theirs:
        case Variable(a), Variable(b):
            return renaming.get(a) == b
        case Constant(a), Constant(b):
            return a == b
        case _:
            return False
