"""The colours of outcomes in plots: rights are green, misses ochre, errors of words violet, of steps warm."""

from __future__ import annotations

from eai.abilities.declaration import AnswerOutcome

OUTCOME_COLORS = {
    AnswerOutcome.SUCCESS: "#3f7f62",
    AnswerOutcome.PARTLY_RIGHT: "#a3bf8f",
    AnswerOutcome.GOAL_MISSED: "#d8b455",
    AnswerOutcome.PARSING: "#5d5f72",
    AnswerOutcome.HALLUCINATION: "#8a64a0",
    AnswerOutcome.ARGUMENT_NUMBER: "#b99cc8",
    AnswerOutcome.AFFORDANCE: "#e0905a",
    AnswerOutcome.MISSING_STEP: "#bf5348",
    AnswerOutcome.WRONG_ORDER: "#6f94bd",
    AnswerOutcome.ADDITIONAL_STEP: "#a9a9a2",
    AnswerOutcome.UNCATEGORISED: "#c9c6bd",
    AnswerOutcome.SLIP: "#7fb5b5",
    AnswerOutcome.NOT_ANSWERED: "#b8a98c",
    AnswerOutcome.EXCLUDED: "#e6e3db",
}
INK = "#2b2d33"
MUTED = "#8b8d94"
RULE = "#dcdad3"
ACCENT = "#2f6690"
LINES = ("#2f6690", "#bf5348", "#3f7f62", "#d8b455", "#8a64a0", "#e0905a", "#5d5f72", "#6f94bd", "#a3bf8f")
"""The colours of models that share an axis, used again from the start if there are more."""
