"""The VirtualHome domain: a household of some 300 objects, one character and 45 actions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from eai.benchmarks.virtualhome import predicates as p
from eai.benchmarks.virtualhome.operators import make_operators, make_switch_hands_action
from eai.world.domain import Domain
from eai.world.operator import Operator, sort_checks_in_paper_order


@cache
def make_domain_with_checks_in_paper_order() -> Domain:
    """Return the domain whose operators make their checks in the order of the paper's text."""
    return _build_household([sort_checks_in_paper_order(operator) for operator in make_operators()])


@cache
def make_domain_with_switch_hands_action() -> Domain:
    """Return the domain for subgoals. Subgoals name hands, but the action GRAB chooses the hand itself.

    Only this domain has the action SWITCH_HANDS, which moves an object to the other hand.
    """
    return make_domain_with_checks_in_paper_order().replace_operators(make_switch_hands_action())


def make_domain_with_checks_in_reference_order() -> Domain:
    """Return the domain whose operators make their checks in the order of the paper's package."""
    return _build_household(make_operators())


def _build_household(operators: Sequence[Operator]) -> Domain:
    """Return the household domain with the given operators.

    The character sees the objects that it holds, and the objects of its room that are not in a closed
    container. It knows all rooms. It sees the relations `NEXT_TO` and `FACING` only from itself to objects,
    because most facts of a scene are such relations between objects.
    """
    return Domain(
        "virtualhome",
        p.VOCABULARY,
        tuple(operators),
        visible=p.held(p.X) | (p.in_same_room(p.X) & ~p.shut_in(p.X)),
        landmarks=p.room(p.X),
        egocentric=(p.next_to, p.facing),
    )
