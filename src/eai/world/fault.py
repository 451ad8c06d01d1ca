"""The kinds of fault that a step of a plan may have, and whether a slip is noticed."""

from __future__ import annotations

from enum import Enum
from typing import Literal, TypeAlias


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


NOT_EXECUTED = frozenset({FaultKind.PARSING, FaultKind.HALLUCINATION, FaultKind.ARGUMENT_NUMBER})
"""The kinds of error for which nothing of an answer is carried out, so that its goals say nothing."""

Notice: TypeAlias = Literal["detected", "silent"]
"""Whether whoever acts learns of a slip.

A detected slip ends the plan. After a silent one the plan continues as if the action had worked, and what
depends on it fails later.
"""
