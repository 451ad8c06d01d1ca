"""Claims of the paper, and findings on them from records."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from math import comb
from typing import NamedTuple

from evidence import Evidence, Suite


class Status(str, Enum):
    REPRODUCED = "reproduced"
    IN_PART = "reproduced in part"
    NOT_SUPPORTED = "not supported"
    ARTEFACT = "an artefact"
    CANNOT_BE_CHECKED = "cannot be checked"
    NOT_JUDGED = "not judged"


class Row(NamedTuple):
    """A row of figures: the paper's, empty if it prints none, and ours."""

    what: str
    printed: str
    ours: str


@dataclass(frozen=True)
class Finding:
    """The finding on a claim: a status by the claim's own rule, a sentence, and figures."""

    status: Status
    summary: str
    rows: Sequence[Row] = ()


@dataclass(frozen=True)
class Claim:
    """A claim of the paper.

    Attributes:
        says: The paper's claim in our words.
        place: Section or table of the paper with the claim.
        needs: Suites whose records are needed; empty if the paper's own figures suffice.
        rule: Condition under which the claim counts as reproduced.
        find: Function that computes the finding; a finding is never written by hand.
        note: Further information for the reader.
        plans: Whether a planner is needed, which takes minutes.
    """

    key: str
    title: str
    says: str
    place: str
    needs: frozenset[Suite]
    rule: str
    find: Callable[[Evidence], Finding]
    note: str = ""
    plans: bool = False

    @property
    def anchor(self) -> str:
        """Anchor of the claim's section, as GitHub makes it from the heading."""
        kept = "".join(c for c in f"{self.key} {self.title}".lower() if c.isalnum() or c in " -_")
        return kept.replace(" ", "-")


def by_degree(whole: bool, part: bool) -> Status:
    """Return the status: reproduced, in part, or not supported."""
    if whole:
        return Status.REPRODUCED
    return Status.IN_PART if part else Status.NOT_SUPPORTED


def fisher(first: int, second: int, tasks: int) -> float:
    """Return the p-value of Fisher's exact test, two-sided, of two shares of the same number of tasks."""
    total, hits = 2 * tasks, first + second

    def chance(k: int) -> float:
        return comb(hits, k) * comb(total - hits, tasks - k) / comb(total, tasks)

    ways = range(max(0, hits - tasks), min(hits, tasks) + 1)
    return sum(chance(k) for k in ways if chance(k) <= chance(first) * (1 + 1e-9))


def sign_test(fewer: int, more: int) -> float:
    """Return the p-value of the two-sided sign test without ties: the chance of so uneven a split."""
    number = fewer + more
    tail = sum(comb(number, k) for k in range(min(fewer, more) + 1)) / 2**number
    return min(1.0, 2 * tail)
