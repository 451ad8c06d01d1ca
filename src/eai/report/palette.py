"""The colours of outcomes in plots: rights are green, misses ochre, errors of words violet, of steps warm."""

from __future__ import annotations

from eai.metrics.breakdown import Outcome

OUTCOME_COLORS = {
    Outcome.SUCCESS: "#3f7f62",
    Outcome.PARTLY_RIGHT: "#a3bf8f",
    Outcome.GOAL_MISSED: "#d8b455",
    Outcome.PARSING: "#5d5f72",
    Outcome.HALLUCINATION: "#8a64a0",
    Outcome.ARGUMENT_NUMBER: "#b99cc8",
    Outcome.AFFORDANCE: "#e0905a",
    Outcome.MISSING_STEP: "#bf5348",
    Outcome.WRONG_ORDER: "#6f94bd",
    Outcome.ADDITIONAL_STEP: "#a9a9a2",
    Outcome.UNCATEGORISED: "#c9c6bd",
    Outcome.EXCLUDED: "#e6e3db",
}
INK = "#2b2d33"
MUTED = "#8b8d94"
RULE = "#dcdad3"
ACCENT = "#2f6690"
LINES = ("#2f6690", "#bf5348", "#3f7f62", "#d8b455", "#8a64a0", "#e0905a", "#5d5f72", "#6f94bd", "#a3bf8f")
"""The colours of models that share an axis, used again from the start if there are more."""
