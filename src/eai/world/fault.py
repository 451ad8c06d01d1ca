"""The kinds of fault that a step of a plan may have."""

from __future__ import annotations

from enum import Enum


class FaultKind(str, Enum):
    """The kinds of error of the paper (section "Error types"), by their wire strings.

    `ADDITIONAL_STEP` is a remark: the step is skipped and the plan continues. All others end the plan.
    `SLIP`, which only experiments have, is no error of whoever acts: the step was possible and did not work.
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


NOT_CARRIED_OUT = frozenset({FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER})
"""The kinds of error for which nothing of an answer is carried out, so that its goals say nothing."""
