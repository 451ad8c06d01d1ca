"""The kinds of fault that a step may have, and whether agents notice slips (actions without effect)."""

from __future__ import annotations

from enum import Enum
from typing import Literal, TypeAlias


class FaultKind(str, Enum):
    """The kinds of error of a step in a plan. The values are the names that answer files contain.

    The paper "Embodied Agent Interface" defines them in its section "Error types", except the last two.
    `UNCATEGORISED` is the kind of an action at which the reference package aborts or the world raises an
    exception, and of an episode that cannot be replayed.

    After `ADDITIONAL_STEP` the step is skipped and the plan continues. All other kinds end the plan. `SLIP`
    occurs only in experiments and is not an error of the agent: the action was possible but had no effect.
    """

    PARSING = "parsing"
    HALLUCINATION = "hallucination"
    ARGUMENT_NUMBER = "argument_number"
    AFFORDANCE = "affordance"
    ADDITIONAL_STEP = "additional_step"
    MISSING_STEP = "missing_step"
    WRONG_ORDER = "wrong_order"
    UNCATEGORISED = "uncategorised"
    SLIP = "slip"


FAULT_PRECEDENCE = (
    FaultKind.UNCATEGORISED,
    FaultKind.ADDITIONAL_STEP,
    FaultKind.AFFORDANCE,
    FaultKind.WRONG_ORDER,
    FaultKind.MISSING_STEP,
)
"""Order of kinds of fault: if a step has several faults, the kind that comes first is reported."""

NOT_EXECUTED = frozenset({FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER})
"""Kinds of error for which no step of an answer is executed, and the answer's goals are not evaluated."""

Notice: TypeAlias = Literal["detected", "silent"]
"""Whether the agent notices a slip (a possible action without effect).

A detected slip ends the plan. After a silent slip the plan continues as if the action had worked, and steps
that depend on the action fail later.
"""
