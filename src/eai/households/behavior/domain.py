"""The BEHAVIOR domain: everyday household chores with two hands, sliced food, dust, stains and heat."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from eai.households.behavior.operators import declared_operators, going_there
from eai.households.behavior.predicates import VOCABULARY, X, held, is_sliced, part, shut_in
from eai.world.domain import Domain
from eai.world.history import was_possible_before
from eai.world.operator import in_paper_order


@cache
def as_meant() -> Domain:
    """The domain as the paper means it: the declared one, with checks in the paper's order."""
    declared = as_declared()
    return replace(declared, operators=tuple(going_there(in_paper_order(o)) for o in declared.operators))


def as_declared() -> Domain:
    """The domain with the reference's order of checks.

    The robot sees what it holds and what is in nothing that is closed, but no parts of what is whole.
    """
    return Domain(
        "behavior",
        VOCABULARY,
        declared_operators(),
        was_possible_before,
        visible=(held(X) | ~shut_in(X)) & (~part(X) | is_sliced(X)),
    )
