"""Stacked bars: what the answers of each run came to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from eai.abilities.declaration import AnswerOutcome, label_of
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title
from eai.results.palette import OUTCOME_COLORS
from eai.results.plot_text import clipped
from eai.results.rate import Rate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH = 8.2
_BAR = 0.27
_HEAD = 0.62


def draw(runs: Sequence[RunSummary]) -> Figure | None:
    """The runs of one domain and protocol, a panel an ability; None if there are none."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    panels = [list(items) for _, items in groupby(runs, key=lambda item: item.key.ability)]
    if not panels:
        return None
    heights = [_HEAD + _BAR * len(items) for items in panels]
    figure = Figure(figsize=(_WIDTH, sum(heights) + 0.55), layout="constrained")
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
    labels = [f"{clipped(item.key.model)}  {number:,}" for item, number in zip(items, answers, strict=True)]
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
