"""Which planner judges operators: a choice that can be made without loading any."""

from __future__ import annotations

from enum import Enum


class PlannerChoice(str, Enum):
    """Which planner judges operators in transition modeling."""

    FULL = "full"
    """The built-in search, and Fast Downward for what it cannot decide."""
    BUILT_IN = "built_in"
    FAST_DOWNWARD = "fast_downward"
    NONE = "none"
