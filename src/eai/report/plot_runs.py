"""Plots of runs: what they come to, and how.

Stacked bars say what the answers of each run came to; flows from answer to outcome show how many answers are
left after each stage, and what the others were lost to; matrices are shares by action and by predicate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import accumulate, groupby
from typing import TYPE_CHECKING

from eai.abilities.declaration import AnswerOutcome, label_of
from eai.abilities.protocol import Ability
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title
from eai.results.lines import MODEL
from eai.results.plots import (
    INK,
    OUTCOME_COLORS,
    SOFT,
    canvas,
    clipped,
    draw_band,
    draw_matrix,
    sheet,
)
from eai.results.rate import NOTHING, Rate
from eai.results.table import Cell, Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 8.2
_BAR = 0.27
_HEAD = 0.62


def draw_outcomes(runs: Sequence[RunSummary]) -> Figure | None:
    """The runs of one domain and protocol, a panel an ability; None if there are none."""
    from matplotlib.patches import Patch

    panels = [list(items) for _, items in groupby(runs, key=lambda item: item.key.ability)]
    if not panels:
        return None
    heights = [_HEAD + _BAR * len(items) for items in panels]
    figure = sheet(_WIDTH, sum(heights) + 0.55)
    grid = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": heights})
    for panel, items in zip(grid[:, 0], panels, strict=True):
        _draw_ability(panel, items)
    kinds = [kind for kind in AnswerOutcome if any(_count(item, kind) for item in runs)]
    handles = [Patch(color=OUTCOME_COLORS[kind], label=label_of(kind.value)) for kind in kinds]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False, fontsize=7.5)
    return figure


def _draw_ability(panel: Axes, items: Sequence[RunSummary]) -> None:
    panel.set_title(ability_title(items[0].key.ability))
    panel.set_xlim(0, 100)
    panel.set_xticks([0, 25, 50, 75, 100], labels=["0", "25", "50", "75", "100 %"])
    answers = [sum(_count(item, kind) for kind in AnswerOutcome) for item in items]
    labels = [
        f"{clipped(item.key.name)}\u2002{number:,}" for item, number in zip(items, answers, strict=True)
    ]
    panel.set_yticks(range(len(items)), labels=labels)
    panel.text(-0.01, 1, "n", transform=panel.transAxes, fontsize=7.5, ha="right", va="bottom")
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    for place, (item, scored) in enumerate(zip(items, answers, strict=True)):
        widths = {kind: Rate(_count(item, kind), scored).percent or 0.0 for kind in AnswerOutcome}
        shown = {kind: width for kind, width in widths.items() if width}
        starts = accumulate(shown.values(), initial=0.0)
        bars = list(zip(starts, shown.values(), strict=False))
        colors = [OUTCOME_COLORS[kind] for kind in shown]
        panel.broken_barh(bars, (place - 0.37, 0.74), facecolors=colors, linewidth=0)


def _count(item: RunSummary, kind: AnswerOutcome) -> int:
    return 0 if kind is AnswerOutcome.EXCLUDED else item.breakdown.outcomes.get(kind, 0)


_MOST_NAMES = 40
"""So many fit a page."""

_F1 = "F1 of clauses, percent"


def draw_actions(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by action of each model, of one ability; None if they are not known."""
    label = {Ability.TRANSITION_MODELING: _F1}.get(runs[0].key.ability, "percent of steps executed")
    return _draw({item.key.name: item.breakdown.by_action for item in runs}, label)


def draw_predicates(runs: Sequence[RunSummary]) -> Figure | None:
    """The shares by predicate of each model, of one ability; None if they are not known."""
    found = {Ability.TRANSITION_MODELING: _F1, Ability.GOAL_INTERPRETATION: "percent of goals found"}
    label = found.get(runs[0].key.ability, "percent of goals reached")
    return _draw({item.key.name: item.breakdown.by_predicate for item in runs}, label)


def _draw(models: Mapping[str, Mapping[str, Rate]], label: str) -> Figure | None:
    rows: list[Mapping[str, Cell]] = []
    for name in _most_frequent(list(models.values())):
        for model, rates in models.items():
            rate = rates.get(name, NOTHING)
            rows.append({"name": name, MODEL: model, "share": Estimate.of_rate(rate)})
    return draw_matrix(rows, ("name",), "share", label, zeros=True)


def _most_frequent(columns: Sequence[Mapping[str, Rate]]) -> list[str]:
    """The names with most cases, in order; answers can have any number of names of their own."""
    cases: dict[str, float] = {}
    for column in columns:
        for name, rate in column.items():
            cases[name] = cases.get(name, 0) + rate.denominator
    return sorted(sorted(cases, key=lambda name: (-cases[name], name))[:_MOST_NAMES])


_FLOWS_PER_ROW = 2
_SIZE = (3.7, 2.0)
"""The room of a model, in inches."""
_APART = (6.1, 180.0)
"""How far one model is from the next: in stages across, in percent down."""
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


def draw_flow(runs: Sequence[RunSummary]) -> Figure | None:
    """The runs of one ability, a panel a model; None if they have no plans."""
    flows = [(item.key.name, flow) for item in runs if (flow := item.breakdown.flow) and flow["answers"]]
    if not flows:
        return None
    columns = min(_FLOWS_PER_ROW, len(flows))
    rows = -(-len(flows) // columns)
    left, top = -0.42, 139.0
    across, up = (left, left + _APART[0] * columns), (top - _APART[1] * rows, top)
    figure, panel = canvas((_SIZE[0] * columns, _SIZE[1] * rows), across, up)
    for place, (model, flow) in enumerate(flows):
        row, column = divmod(place, columns)
        _draw_flow_of(panel, (_APART[0] * column, _TOP - _APART[1] * row), model, flow)
    return figure


def _draw_flow_of(panel: Axes, corner: tuple[float, float], model: str, flow: Mapping[str, int]) -> None:
    """Bands flow from left to right at the top; what is lost bends down at the end of its stage."""
    shares = [Rate(count, flow["answers"]).percent or 0.0 for count in flow.values()]
    left, top = corner
    panel.text(left - 0.35, top + 27, clipped(model), fontsize=9)
    before = top
    for stage, (label, kind) in enumerate(_LOSSES):
        at, kept, lost = left + stage, shares[stage + 1], shares[stage] - shares[stage + 1]
        draw_band(panel, at, (top - kept, top - kept, kept), OUTCOME_COLORS[AnswerOutcome.SUCCESS])
        if lost >= _SMALLEST_LABELLED:
            end = top - kept - lost - _GAP
            draw_band(panel, at, (top - kept - lost, end, lost), OUTCOME_COLORS[kind])
            text = f"{label} {lost:.0f}"
            before = before - _LINE if abs(end - 5 - before) < _LINE else end - 5
            panel.text(at + 0.1, before, text, fontsize=6, va="center", color=INK)
    for at, (name, share) in enumerate(zip(_STAGES, shares, strict=True)):
        panel.text(left + at, top + 4, f"{share:.0f}", fontsize=7.5, weight="bold", ha="center")
        panel.text(left + at, top + 15, name, fontsize=5.8, ha="center", color=SOFT)
