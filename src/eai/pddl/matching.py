"""Comparing operators with the gold ones, as the paper means it.

The unit is the literal, counted as often as it stands there. Parts of lists are paired so that as many
literals as possible match (an assignment problem, level by level), so that one wrong literal inside a
nested list costs one literal and not the list. Names of variables mean nothing: parameters are matched by
the best of the pairings that agree with their types, bound variables by their quantifiers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import permutations

from eai.logic.formula import Constant, Term, Variable
from eai.logic.matching import heaviest_pairs
from eai.pddl.clauses import (
    Bound,
    Clause,
    Denied,
    Guarded,
    Joined,
    Literal,
    condition_clause,
    effect_clause,
    literals,
)
from eai.pddl.model import PddlAction, type_of

MAX_PERMUTED = 5
"""Up to how many parameters all pairings are tried; above, only that by position."""

Renaming = Mapping[str, str]
"""The gold name of each variable of the answer; a variable without one matches nothing."""


@dataclass(frozen=True, slots=True)
class SideMatch:
    """How one side of an operator (its precondition or its effect) compares with the gold one.

    Each tuple holds names of predicates, in alphabetical order, one for each literal.
    """

    matched: tuple[str, ...] = ()
    additional: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


NO_MATCH = SideMatch()
"""The comparison of nothing with nothing."""


@dataclass(frozen=True, slots=True)
class OperatorMatch:
    """How an operator compares with the gold one."""

    precondition: SideMatch
    effect: SideMatch


def match_operators(predicted: PddlAction, gold: PddlAction) -> OperatorMatch:
    """Compare an operator of an answer with the gold operator of the same name."""
    sides = [
        (condition_clause(predicted.precondition), condition_clause(gold.precondition)),
        (effect_clause(predicted.effect), effect_clause(gold.effect)),
    ]
    most = sum(1 for _, theirs in sides for _ in literals(theirs))
    best: tuple[int, list[tuple[Literal, ...]]] | None = None
    for renaming in _renamings(predicted, gold):
        matches = [_match(ours, theirs, renaming) for ours, theirs in sides]
        size = sum(map(len, matches))
        if best is None or size > best[0]:
            best = (size, matches)
        if size == most:
            break
    found = best[1] if best is not None else [(), ()]
    precondition, effect = (
        _side(ours, theirs, matched) for (ours, theirs), matched in zip(sides, found, strict=True)
    )
    return OperatorMatch(precondition, effect)


def missing_operator(gold: PddlAction) -> OperatorMatch:
    """The comparison with an operator that the answer does not have, or that cannot be read."""
    return OperatorMatch(
        SideMatch(missing=_names(literals(condition_clause(gold.precondition)))),
        SideMatch(missing=_names(literals(effect_clause(gold.effect)))),
    )


def _side(ours: Clause, theirs: Clause, matched: tuple[Literal, ...]) -> SideMatch:
    names = Counter(literal.predicate for literal in matched)
    return SideMatch(
        matched=tuple(sorted(names.elements())),
        additional=_rest(ours, names),
        missing=_rest(theirs, names),
    )


def _rest(clause: Clause, matched: Counter[str]) -> tuple[str, ...]:
    left = Counter(literal.predicate for literal in literals(clause)) - matched
    return tuple(sorted(left.elements()))


def _names(found: Iterator[Literal]) -> tuple[str, ...]:
    return tuple(sorted(literal.predicate for literal in found))


def _renamings(predicted: PddlAction, gold: PddlAction) -> Iterator[Renaming]:
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
    return (renaming for agreeing, renaming in candidates if agreeing == most)


def _match(ours: Clause, theirs: Clause, renaming: Renaming) -> tuple[Literal, ...]:
    """The gold literals that find a partner when one tree is laid upon the other as well as possible."""
    match ours, theirs:
        case Literal(), Literal():
            return (theirs,) if _same(ours, theirs, renaming) else ()
        case Denied(a), Denied(b):
            return _match(a, b, renaming)
        case Bound(scope, name, category, part), Bound() if (scope, category) == (theirs.scope, theirs.type):
            return _match(part, theirs.part, {**renaming, name: theirs.name})
        case Guarded(), Guarded():
            return (
                *_match(ours.guard, theirs.guard, renaming),
                *_match(ours.part, theirs.part, renaming),
            )
        case Joined(), Joined() if ours.connective is not theirs.connective:
            return _match_unlike(ours, theirs, renaming)
        case (Joined(), _) | (_, Joined()):
            return _match_lists(_parts(ours), _parts(theirs), renaming)
        case _:
            return ()


def _parts(clause: Clause) -> tuple[Clause, ...]:
    """The parts of a list; anything else is a list of one."""
    return clause.parts if isinstance(clause, Joined) else (clause,)


def _match_lists(
    ours: tuple[Clause, ...], theirs: tuple[Clause, ...], renaming: Renaming
) -> tuple[Literal, ...]:
    grid = [[_match(a, b, renaming) for b in theirs] for a in ours]
    pairs = heaviest_pairs([[len(cell) for cell in row] for row in grid])
    return tuple(literal for row, column in pairs for literal in grid[row][column])


def _match_unlike(ours: Joined, theirs: Joined, renaming: Renaming) -> tuple[Literal, ...]:
    """A conjunction and a disjunction match only as far as one of them is a part of the other."""
    inside = [_match(part, theirs, renaming) for part in ours.parts if isinstance(part, Joined)]
    around = [_match(ours, part, renaming) for part in theirs.parts if isinstance(part, Joined)]
    return max([*inside, *around], key=len, default=())


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
