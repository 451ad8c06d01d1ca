"""The lots that the reference draws between alternatives, which its published runs left to chance.

It calls Python's ``random.choice``. `draw_lots` gives the draws that follow ``random.seed(0)`` before each
answer: one for every subgoal that is kept, alternatives or not, then one for every ``or`` that is left.
"""

from __future__ import annotations

import random

SEED = 0


def draw_lots() -> random.Random:
    """The lots for one answer; a verdict must take them in the reference's order."""
    return random.Random(SEED)  # noqa: S311 - the same generator as the reference's
