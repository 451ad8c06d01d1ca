"""The BEHAVIOR domain: household chores with two hands, sliced food, dust, stains and heat."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from eai.benchmarks.behavior.operators import add_robot_movement, make_operators
from eai.benchmarks.behavior.predicates import VOCABULARY, X, held, is_sliced, part, shut_in
from eai.world.domain import Domain
from eai.world.history import find_when_action_was_possible
from eai.world.operator import Operator, sort_checks_in_paper_order


@cache
def make_domain_with_checks_in_paper_order() -> Domain:
    """Return the domain whose operators check preconditions in the order of the paper's text.

    This order decides which kind of error an impossible action has. Actions move the robot to their objects.
    """
    return _build_household(
        [add_robot_movement(sort_checks_in_paper_order(operator)) for operator in make_operators()]
    )


def make_domain_with_checks_in_reference_order() -> Domain:
    """Return the domain whose operators check preconditions in the order of the paper's package."""
    return _build_household(make_operators())


def _build_household(operators: Sequence[Operator]) -> Domain:
    """Return the household domain with the given operators.

    The robot sees held objects, and objects that are not shut in. It does not see halves of unsliced objects.
    """
    return Domain(
        "behavior",
        VOCABULARY,
        tuple(operators),
        find_when_action_was_possible,
        visible=(held(X) | ~shut_in(X)) & (~part(X) | is_sliced(X)),
    )
