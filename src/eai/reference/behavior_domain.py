"""The BEHAVIOR domain as eai-eval 1.0.5 has it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, reduce

from eai.households.behavior.domain import as_declared
from eai.reference.behavior_quirks import QUIRKS, half_done_transfers
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State

SUBGOAL_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
    FaultKind.AFFORDANCE,
)
"""Which kind counts in the reference's subgoal decomposition (``checkers.py`` handle_compound_errors)."""


@cache
def as_in_reference() -> Domain:
    """The reference's order of checks and all of its quirks."""
    return reduce(lambda domain, quirk: quirk.apply(domain), QUIRKS, as_declared())


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
    return replace(as_declared(), operators=half_done_transfers())
