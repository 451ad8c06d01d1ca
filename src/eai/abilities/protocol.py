"""What a suite is of: the ability that is asked for, and the protocol, which says what the numbers mean."""

from __future__ import annotations

from enum import Enum


class Protocol(str, Enum):
    """A named, versioned set of rules for scoring.

    `STRICT` is what the paper says, with the defects of its reference package mended. `EAI_1_0_5` gives the
    verdicts of that package, release 1.0.5, defect by defect.
    """

    STRICT = "strict"
    EAI_1_0_5 = "eai-1.0.5"


class Ability(str, Enum):
    """The paper's four abilities."""

    GOAL_INTERPRETATION = "goal_interpretation"
    SUBGOAL_DECOMPOSITION = "subgoal_decomposition"
    ACTION_SEQUENCING = "action_sequencing"
    TRANSITION_MODELING = "transition_modeling"
