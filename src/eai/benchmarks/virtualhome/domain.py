"""The VirtualHome domain: a household of some 300 objects, one character, 45 actions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from eai.benchmarks.virtualhome import predicates as p
from eai.benchmarks.virtualhome.operators import make_operators, switch_hands
from eai.world.domain import Domain
from eai.world.operator import Operator, sort_checks


@cache
def as_meant() -> Domain:
    """The domain as the paper means it: the declared one, with checks in the paper's order."""
    return _build_household([sort_checks(operator) for operator in make_operators()])


@cache
def with_either_hand() -> Domain:
    """The domain as subgoals have it, which say in which hand a thing is: GRAB chooses the hand by itself."""
    return as_meant().replace_operators(switch_hands())


def as_declared() -> Domain:
    """The domain with the reference's order of checks."""
    return _build_household(make_operators())


def _build_household(operators: Sequence[Operator]) -> Domain:
    """The household with these operators.

    The character sees what it holds and what is in its room but in nothing closed; it knows all rooms.
    What is near or faced it is told of itself alone: between things, these are most of a scene's facts.
    """
    return Domain(
        "virtualhome",
        p.VOCABULARY,
        tuple(operators),
        visible=p.held(p.X) | (p.in_same_room(p.X) & ~p.shut_in(p.X)),
        landmarks=p.room(p.X),
        egocentric=(p.next_to, p.facing),
    )
