"""The BEHAVIOR domain: everyday household chores with two hands, sliced food, dust, stains and heat."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from eai.benchmarks.behavior.operators import add_movement, make_operators
from eai.benchmarks.behavior.predicates import VOCABULARY, X, held, is_sliced, part, shut_in
from eai.world.domain import Domain
from eai.world.history import was_possible_before
from eai.world.operator import Operator, sort_checks


@cache
def as_meant() -> Domain:
    """The domain as the paper means it: the declared one, with checks in the paper's order."""
    return _build_household([add_movement(sort_checks(operator)) for operator in make_operators()])


def as_declared() -> Domain:
    """The domain with the reference's order of checks."""
    return _build_household(make_operators())


def _build_household(operators: Sequence[Operator]) -> Domain:
    """The household with these operators.

    The robot sees what it holds and what is in nothing that is closed, but no parts of what is whole.
    """
    return Domain(
        "behavior",
        VOCABULARY,
        tuple(operators),
        was_possible_before,
        visible=(held(X) | ~shut_in(X)) & (~part(X) | is_sliced(X)),
    )
