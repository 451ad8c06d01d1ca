"""Shares: a part and a whole, such as the satisfied goals of all goals."""

from __future__ import annotations

from typing import NamedTuple


class Share(NamedTuple):
    """A part and a whole: satisfied goals of all goals, say, or the contribution of an answer to a rate."""

    numerator: int | float
    denominator: int | float


class GoalTallies(NamedTuple):
    """Number of satisfied goals, and of all goals, for each of the three kinds."""

    state: Share
    relation: Share
    action: Share
