"""From answer to outcome: how many answers are left after each stage, and what the others were lost to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.abilities.declaration import AnswerOutcome
from eai.report.run_summary import RunSummary
from eai.results.breakdown import Flow
from eai.results.palette import INK, OUTCOME_COLORS
from eai.results.plot_analyses import Band, draw_band
from eai.results.plot_text import clipped
from eai.results.rate import Rate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PER_ROW = 2
_SIZE = (3.7, 2.0)
_STAGES = ("answers", "parsed", "names known", "well formed", "executed", "goal reached")
_LOSSES = (
    ("unreadable", AnswerOutcome.PARSING),
    ("unknown names", AnswerOutcome.HALLUCINATION),
    ("argument number", AnswerOutcome.ARGUMENT_NUMBER),
    ("failed step", AnswerOutcome.MISSING_STEP),
    ("goal missed", AnswerOutcome.GOAL_MISSED),
)
_TOP = 100.0
_GAP = 9.0
"""How far a band bends down that leaves the flow."""
_LINE = 9.0
"""Percent that a line of text takes; what would stand on the line of the loss before stands below it."""

_SMALLEST_LABELLED = 0.5


def draw(runs: Sequence[RunSummary]) -> Figure | None:
    """The runs of one ability, a panel a model; None if they have no plans."""
    from matplotlib.figure import Figure

    flows = [(item.key.model, flow) for item in runs if (flow := item.breakdown.flow) and flow.answers]
    if not flows:
        return None
    columns = min(_PER_ROW, len(flows))
    rows = -(-len(flows) // columns)
    figure = Figure(figsize=(_SIZE[0] * columns, _SIZE[1] * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False)
    for place, panel in enumerate(grid.flat):
        panel.set_axis_off()
        if place < len(flows):
            _draw_model(panel, *flows[place])
    return figure


def _draw_model(panel: Axes, model: str, flow: Flow) -> None:
    """Bands flow from left to right at the top; what is lost bends down at the end of its stage."""
    shares = [Rate(count, flow.answers).percent or 0.0 for count in flow]
    panel.set_xlim(-0.35, len(_STAGES) - 0.3)
    panel.set_ylim(-_GAP - 5 - 2 * _LINE, 124)
    panel.set_title(clipped(model))
    before = _TOP
    for stage, (label, kind) in enumerate(_LOSSES):
        kept, lost = shares[stage + 1], shares[stage] - shares[stage + 1]
        draw_band(panel, stage, Band(_TOP - kept, _TOP - kept, kept), OUTCOME_COLORS[AnswerOutcome.SUCCESS])
        if lost >= _SMALLEST_LABELLED:
            end = _TOP - kept - lost - _GAP
            draw_band(panel, stage, Band(_TOP - kept - lost, end, lost), OUTCOME_COLORS[kind])
            text = f"{label} {lost:.0f}"
            before = before - _LINE if abs(end - 5 - before) < _LINE else end - 5
            panel.text(stage + 0.1, before, text, fontsize=6, va="center", color=INK)
    for stage, (name, share) in enumerate(zip(_STAGES, shares, strict=True)):
        panel.text(stage, 104, f"{share:.0f}", fontsize=7.5, weight="bold", ha="center")
        panel.text(stage, 115, name, fontsize=5.8, ha="center", color="#55575e")
