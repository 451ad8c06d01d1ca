"""Shares, such as the share of a task's goals that a plan satisfies."""

from __future__ import annotations

from typing import NamedTuple


class Share(NamedTuple):
    """A share as a numerator and a denominator.

    For example, the satisfied goals among all goals, or the contribution of an answer to a rate.
    """

    numerator: int | float
    denominator: int | float


class GoalTallies(NamedTuple):
    """Shares of satisfied goals: a share for each of the three kinds of goal."""

    state: Share
    relation: Share
    action: Share
