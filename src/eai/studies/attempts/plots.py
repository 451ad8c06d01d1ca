"""Task success by the number of attempts: a curve an arm, the one without feedback dashed."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import TYPE_CHECKING

from eai.abilities.experiment import Feedback
from eai.results.plots import LINES, MUTED, RULE, clipped
from eai.studies.attempts.analysis import Arm, success_by_attempt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SIZE = (3.5, 2.8)
"""A column of a page, in inches."""
_LEGEND_ROW = 0.17
_APART = 0.05
"""How far arms stand beside each other, so that their intervals can be distinguished."""


def draw(arms: Sequence[Arm]) -> Figure | None:
    """Success with its 95 % intervals; None if no task had more than one attempt."""
    from matplotlib.figure import Figure

    shown = [arm for arm in arms if arm.attempts > 1]
    if not shown:
        return None
    figure = Figure(figsize=(_SIZE[0], _SIZE[1] + _LEGEND_ROW * len(shown)), layout="constrained")
    panel = figure.subplots()
    for number, arm in enumerate(shown):
        estimates = success_by_attempt(arm)
        places = [k + _APART * (number - (len(shown) - 1) / 2) for k in range(1, arm.attempts + 1)]
        values, lows, highs = (
            [nan if x is None else x for x in column]
            for column in zip(*[(each.value, each.low, each.high) for each in estimates], strict=True)
        )
        below = [value - low for value, low in zip(values, lows, strict=True)]
        above = [high - value for value, high in zip(values, highs, strict=True)]
        has_feedback = arm.experiment.feedback is not Feedback.NONE
        panel.errorbar(
            places,
            values,
            yerr=[below, above],
            color=LINES[number % len(LINES)] if has_feedback else MUTED,
            linestyle="-" if has_feedback else "--",
            marker="o",
            markersize=3,
            linewidth=1.2,
            elinewidth=0.7,
            label=f"{clipped(arm.name)}, n = {estimates[0].denominator:,.0f}",
        )
    panel.set_xticks(range(1, max(arm.attempts for arm in shown) + 1))
    panel.set_xlabel("attempts")
    panel.set_ylabel("task success in percent")
    panel.set_ylim(0, 100)
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=1, frameon=False, fontsize=7)
    return figure
