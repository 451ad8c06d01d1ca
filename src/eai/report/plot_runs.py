"""Plots of runs: what they come to, and how.

A radar a model has the columns of the paper's overview as axes; stacked bars say what the answers of each run
came to; flows from answer to outcome show how many answers are left after each stage, and what the others
were lost to; matrices are shares by action and by predicate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from eai.abilities.declaration import AnswerOutcome, declaration_of, label_of, the_four
from eai.abilities.protocol import Ability
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title
from eai.results.lines import MODEL
from eai.results.plots import ACCENT, INK, MUTED, OUTCOME_COLORS, RULE, clipped, draw_band, draw_matrix, sheet
from eai.results.rate import Rate
from eai.results.table import Cell, Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

_PER_ROW = 3
_SIDE = 2.35
_FEWEST_AXES = 3


def draw_radar(runs: Sequence[RunSummary]) -> Figure | None:
    """The models of one domain and protocol side by side; None if they have too few axes to span an area."""
    from matplotlib.projections.polar import PolarAxes

    values = _values(runs)
    labels = _labels()
    axes = [name for name in labels if any(name in known for known in values.values())]
    if len(axes) < _FEWEST_AXES:
        return None
    columns = min(_PER_ROW, len(values))
    rows = -(-len(values) // columns)
    figure = sheet(_SIDE * columns, _SIDE * rows * 1.08)
    for place, (model, known) in enumerate(values.items(), 1):
        panel = figure.add_subplot(rows, columns, place, projection="polar")
        assert isinstance(panel, PolarAxes)  # noqa: S101 - what the projection gives
        _draw_model(panel, model, {labels[name]: known.get(name) for name in axes})
    return figure


def _labels() -> Mapping[str, str]:
    """The main metrics by ability and name, as they are called at the end of an axis."""
    return {
        f"{ability.value}/{metric}": f"{declared.short}\n{label if label.isupper() else label.lower()}"
        for ability, declared in the_four().items()
        for metric, label in declared.main.items()
    }


def _values(runs: Sequence[RunSummary]) -> Mapping[str, Mapping[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for item in runs:
        for metric in declaration_of(item.key.ability).main:
            percent = item.rates[metric].percent if metric in item.rates else None
            if percent is not None:
                found.setdefault(item.key.name, {})[f"{item.key.ability.value}/{metric}"] = percent
    return dict(sorted(found.items()))


def _draw_model(panel: PolarAxes, model: str, values: Mapping[str, float | None]) -> None:
    """An unknown rate has no mark; the line is broken there, and without a whole line there is no area."""
    angles = [2 * math.pi * i / len(values) for i in range(len(values))]
    panel.set_theta_offset(math.pi / 2)
    panel.set_theta_direction(-1)
    panel.set_ylim(0, 100)
    panel.set_yticks([25, 50, 75, 100], labels=["", "50", "", "100"], color=MUTED, fontsize=6)
    labels = [label if value is not None else f"{label}\n(none)" for label, value in values.items()]
    panel.set_xticks(angles, labels=labels, fontsize=6.5)
    panel.grid(color=RULE, linewidth=0.7)
    panel.spines["polar"].set_color(RULE)
    heights = [math.nan if value is None else value for value in values.values()]
    around, closed = [*angles, angles[0]], [*heights, heights[0]]
    panel.plot(around, closed, "o-", color=ACCENT, linewidth=1.4, markersize=2.6)
    if None not in values.values():
        panel.fill(around, closed, color=ACCENT, alpha=0.16)
    panel.set_title(clipped(model), fontsize=8.5, pad=12, loc="center")


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
    labels = [f"{clipped(item.key.name)}  {number:,}" for item, number in zip(items, answers, strict=True)]
    panel.set_yticks(range(len(items)), labels=labels)
    panel.text(-0.01, 1, "n", transform=panel.transAxes, fontsize=7.5, ha="right", va="bottom")
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    for place, (item, scored) in enumerate(zip(items, answers, strict=True)):
        start = 0.0
        for kind in AnswerOutcome:
            width = Rate(_count(item, kind), scored).percent or 0.0
            if width:
                panel.barh(place, width, left=start, height=0.74, color=OUTCOME_COLORS[kind], linewidth=0)
                start += width


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
            rate = rates.get(name, Rate(0, 0))
            share = Estimate(rate.percent, numerator=rate.numerator, denominator=rate.denominator)
            rows.append({"name": name, MODEL: model, "share": share})
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
    figure = sheet(_SIZE[0] * columns, _SIZE[1] * rows)
    grid = figure.subplots(rows, columns, squeeze=False)
    for place, panel in enumerate(grid.flat):
        panel.set_axis_off()
        if place < len(flows):
            _draw_flow_of(panel, *flows[place])
    return figure


def _draw_flow_of(panel: Axes, model: str, flow: Mapping[str, int]) -> None:
    """Bands flow from left to right at the top; what is lost bends down at the end of its stage."""
    shares = [Rate(count, flow["answers"]).percent or 0.0 for count in flow.values()]
    panel.set_xlim(-0.35, len(_STAGES) - 0.3)
    panel.set_ylim(-_GAP - 5 - 2 * _LINE, 124)
    panel.set_title(clipped(model))
    before = _TOP
    for stage, (label, kind) in enumerate(_LOSSES):
        kept, lost = shares[stage + 1], shares[stage] - shares[stage + 1]
        draw_band(panel, stage, (_TOP - kept, _TOP - kept, kept), OUTCOME_COLORS[AnswerOutcome.SUCCESS])
        if lost >= _SMALLEST_LABELLED:
            end = _TOP - kept - lost - _GAP
            draw_band(panel, stage, (_TOP - kept - lost, end, lost), OUTCOME_COLORS[kind])
            text = f"{label} {lost:.0f}"
            before = before - _LINE if abs(end - 5 - before) < _LINE else end - 5
            panel.text(stage + 0.1, before, text, fontsize=6, va="center", color=INK)
    for stage, (name, share) in enumerate(zip(_STAGES, shares, strict=True)):
        panel.text(stage, 104, f"{share:.0f}", fontsize=7.5, weight="bold", ha="center")
        panel.text(stage, 115, name, fontsize=5.8, ha="center", color="#55575e")
