"""From answers to the leaves of the taxonomy of errors: bands from all to stages, which leaves make up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.abilities.declaration import AnswerOutcome
from eai.results.plots import COLUMN, INK, MUTED, OUTCOME_COLORS, cases_of, clipped, draw_band, value_of
from eai.results.table import Cell

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_GAP = 4.0
"""Percent between stages, and between what leaves of different stages are labelled with."""

_SMALLEST = 0.5
"""Percent below which a leaf is a band without a name."""

_LINE = 5.6
"""Percent that a line of text takes."""

_COLORS: Mapping[str, str] = {
    "success": OUTCOME_COLORS[AnswerOutcome.SUCCESS],
    "grammar": OUTCOME_COLORS[AnswerOutcome.PARSING],
    "runtime": OUTCOME_COLORS[AnswerOutcome.MISSING_STEP],
    "goal": OUTCOME_COLORS[AnswerOutcome.GOAL_MISSED],
}


def draw(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """Draw the outcomes of all models' answers, or of the only one's; None if there are none.

    Args:
        rows: those of a suite in the table of leaves.
    """
    from matplotlib.figure import Figure

    first = rows[0]["model"] if rows else None
    cells = {_leaf(row): row["answers"] for row in rows if row["model"] == first}
    shares = {leaf: value_of(cell) for leaf, cell in cells.items()}
    shares = {leaf: share for leaf, share in shares.items() if share > 0}
    if not shares:
        return None
    stages = list(dict.fromkeys(stage for stage, _ in shares))
    named = [leaf for leaf, share in shares.items() if share >= _SMALLEST]
    figure = Figure(figsize=(COLUMN, 1.2 + 0.13 * len(named)), layout="constrained")
    panel = figure.subplots()
    panel.set_axis_off()
    answers = max(map(cases_of, cells.values()))
    panel.set_title(f"{clipped(str(first))}, percent of {answers:,} answers", fontsize=7.5)
    top, stage_top, text_top = 100.0, 100.0 + _GAP * (len(stages) - 1) / 2, 104.0
    for stage in stages:
        leaves = {leaf: share for leaf, share in shares.items() if leaf[0] == stage}
        whole, color = sum(leaves.values()), _COLORS.get(stage, MUTED)
        draw_band(panel, 0, (top - whole, stage_top - whole, whole), color)
        at = stage_top
        for leaf, share in leaves.items():
            middle = at - share / 2
            panel.fill_between([1, 1.12], at - share, at, facecolor=color, edgecolor="white", linewidth=0.5)
            if share >= _SMALLEST:
                name = leaf[1] or stage.replace("_", " ")
                text_top = min(middle, text_top - _LINE)
                panel.plot([1.12, 1.2], [middle, text_top], color=MUTED, linewidth=0.6)
                panel.text(1.22, text_top, f"{name} {share:.1f}", fontsize=6.5, va="center", color=INK)
            at -= share
        top -= whole
        stage_top -= whole + _GAP
    panel.set_xlim(-0.02, 2.2)
    panel.set_ylim(min(stage_top, text_top) - _GAP, 104 + _GAP)
    return figure


def _leaf(row: Mapping[str, Cell]) -> tuple[str, str]:
    parts = [str(row[level]).replace("_", " ") for level in ("kind", "detail") if row[level]]
    return str(row["stage"]), ": ".join(parts)
