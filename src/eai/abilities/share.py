"""Shares: a part and a whole, such as the satisfied goals of all goals."""

from __future__ import annotations

from typing import NamedTuple


class Share(NamedTuple):
    """A part and a whole: the satisfied goals of all of a kind, or what one answer adds to a rate."""

    numerator: int | float
    denominator: int | float


class GoalTallies(NamedTuple):
    """How many of the goals of each of the three kinds are satisfied, and of how many."""

    state: Share
    relation: Share
    action: Share
