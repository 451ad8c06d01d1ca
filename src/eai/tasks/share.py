"""Shares as numerators and denominators, such as the satisfied goals among all goals of a task."""

from __future__ import annotations

from typing import NamedTuple


class Share(NamedTuple):
    """A share as a numerator and a denominator.

    Examples are the satisfied goals among all goals, and the contribution of one answer to a rate.
    """

    numerator: int | float
    denominator: int | float


class TalliesByGoalKind(NamedTuple):
    """The numbers of satisfied goals and of all goals, by kind of goal."""

    state: Share
    relation: Share
    action: Share
