"""The BEHAVIOR domain: everyday household chores with two hands, sliced food, dust, stains and heat."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, reduce

from eai.benchmarks.behavior.operators import declared_operators, going_there
from eai.benchmarks.behavior.predicates import VOCABULARY
from eai.benchmarks.reference.behavior_quirks import QUIRKS, half_done_transfers
from eai.world.domain import Domain, was_possible_before
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.operator import in_paper_order
from eai.world.state import State

__all__ = ["as_in_reference", "as_in_reference_subgoals", "as_meant", "half_done"]

SUBGOAL_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
)
"""Which kind counts in the reference's subgoal decomposition (``checkers.py`` handle_compound_errors)."""


@cache
def as_meant() -> Domain:
    """The domain of protocol `strict`: checks in the paper's order, defects of the reference mended."""
    declared = _declared()
    return replace(declared, operators=tuple(going_there(in_paper_order(o)) for o in declared.operators))


@cache
def as_in_reference() -> Domain:
    """The domain of protocol `eai-1.0.5`: the reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, _declared())


@cache
def as_in_reference_subgoals() -> Domain:
    """The same for subgoal decomposition, where the reference ranks kinds of error differently."""
    return replace(as_in_reference(), precedence=SUBGOAL_PRECEDENCE)


def half_done(state: State, action: Action) -> State:
    """What the reference makes of a state when it aborts in an action (quirk `transfer_aborts`)."""
    operator = _half_done().compiled.get(action.operator)
    return state if operator is None else operator.apply(state, operator.bind(state, action.arguments))


@cache
def _half_done() -> Domain:
    return replace(_declared(), operators=half_done_transfers())


def _declared() -> Domain:
    return Domain("behavior", VOCABULARY, declared_operators(), was_possible_before)
