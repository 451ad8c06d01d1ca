"""What the paper says, and what records say to it."""

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
    """A figure as printed, empty if the paper has none, and as it comes out."""

    what: str
    printed: str
    ours: str


@dataclass(frozen=True)
class Finding:
    """What comes out: a status by the claim's own rule, a sentence, figures."""

    status: Status
    summary: str
    rows: Sequence[Row] = ()


@dataclass(frozen=True)
class Claim:
    """A claim of the paper.

    Attributes:
        says: what the paper says, in our words.
        place: where it says so.
        needs: the suites whose records it takes; none where the paper's own figures are enough.
        rule: when it counts as reproduced.
        find: says what comes out; a finding is never written by hand.
        note: what else one must know.
        plans: whether it takes a planner, for minutes.
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
        """The address of the claim's section, as GitHub makes it from a heading."""
        kept = "".join(c for c in f"{self.key} {self.title}".lower() if c.isalnum() or c in " -_")
        return kept.replace(" ", "-")


def by_degree(whole: bool, part: bool) -> Status:
    """Reproduced, in part, or not supported."""
    if whole:
        return Status.REPRODUCED
    return Status.IN_PART if part else Status.NOT_SUPPORTED


def fisher(first: int, second: int, tasks: int) -> float:
    """Fisher's exact test, two-sided, of two shares of as many tasks."""
    total, hits = 2 * tasks, first + second

    def chance(k: int) -> float:
        return comb(hits, k) * comb(total - hits, tasks - k) / comb(total, tasks)

    ways = range(max(0, hits - tasks), min(hits, tasks) + 1)
    return sum(chance(k) for k in ways if chance(k) <= chance(first) * (1 + 1e-9))


def sign_test(fewer: int, more: int) -> float:
    """The two-sided sign test without ties: how often a split as uneven, or more so, is chance."""
    number = fewer + more
    tail = sum(comb(number, k) for k in range(min(fewer, more) + 1)) / 2**number
    return min(1.0, 2 * tail)
