"""The comparison of an operator with the gold one, as records have it; `matching` finds it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class SideMatch:
    """How one side of an operator (its precondition or its effect) compares with the gold one.

    Each tuple holds clauses as PDDL, as `predicates_in` reads them, in the order in which they stand.

    Attributes:
        matched: the gold clauses that the answer has.
        additional: the clauses of the answer that are none of them.
        missing: the other gold clauses.
    """

    matched: tuple[str, ...] = ()
    additional: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()


NO_MATCH = SideMatch()
"""The comparison of nothing with nothing."""


class LiteralMatch(NamedTuple):
    """How many literals of one side are matched, additional and missing."""

    matched: int
    additional: int
    missing: int


@dataclass(frozen=True, slots=True)
class OperatorMatch:
    """How an operator compares with the gold one: clause by clause, and literal by literal.

    Attributes:
        renamed: the parameters of the answer that stand for gold ones of another name, with that name.
    """

    precondition: SideMatch
    effect: SideMatch
    precondition_literals: LiteralMatch
    effect_literals: LiteralMatch
    renamed: tuple[tuple[str, str], ...] = ()
