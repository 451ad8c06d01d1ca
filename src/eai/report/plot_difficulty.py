"""Success against what tasks are like: how many goals they have, how long the data set's own plan is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from eai.report.run_summary import RunSummary
from eai.results.breakdown import Breakdown
from eai.results.certainty import Case, Cases, certainty_of_rate
from eai.results.plots import LINES, RULE, clipped
from eai.results.rate import rate_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BIN = 10
"""How many lengths stand together: bins are 0-9, 10-19 and so on, as in the paper's figure."""

_MANY = 10
"""So many goals, and more, stand together."""

_FEWEST = 5
"""Fewer tasks than this say little: their marks are hollow."""
_MOST_WITH_INTERVALS = 3
"""More models than this in one panel leave no room for intervals."""
_PANEL = (3.5, 2.5)
"""A column of a page, in inches, so that letters have the size that they say."""
_LEGEND_ROW = 0.17
_LEGEND_COLUMNS = {1: 1, 2: 3}
"""Number of panels -> names of models beside each other."""
_MARKS = "os^Dv<>ph"
_STYLES = ("-", "--", ":", "-.")
_APART = 0.09
"""How far models stand beside each other where intervals are drawn."""

Bins = Mapping[int, Cases]
"""Bin -> successes of one model; a bin without tasks is not there."""


def draw(runs: Sequence[RunSummary]) -> Figure | None:
    """Success by number of goals and by length of the annotated plan, a line a model.

    None if neither is known, or all tasks are alike.
    """
    from matplotlib.figure import Figure

    panels = [
        ("goals of the task", _goals_label, [by_goals(item.breakdown) for item in runs]),
        ("steps of the annotated plan", _length_label, [by_length(item.breakdown) for item in runs]),
    ]
    panels = [panel for panel in panels if any(len(bins) > 1 for bins in panel[2])]
    if not panels:
        return None
    columns = min(_LEGEND_COLUMNS[len(panels)], len(runs))
    legend = _LEGEND_ROW * -(-len(runs) // columns)
    figure = Figure(figsize=(_PANEL[0] * len(panels), _PANEL[1] + legend), layout="constrained")
    grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    for panel, (label, name_of_bin, series) in zip(grid, panels, strict=True):
        panel.set_xlabel(label)
        _draw_panel(panel, name_of_bin, series, [clipped(item.key.model) for item in runs])
    grid[0].set_ylabel("success in percent")
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=7)
    return figure


def by_goals(breakdown: Breakdown) -> Bins:
    """Successes by number of goals; many goals stand together."""
    return _binned(breakdown.by_goals, lambda goals: min(goals, _MANY))


def by_length(breakdown: Breakdown) -> Bins:
    """Successes by length of the annotated plan, in whole tens."""
    return _binned(breakdown.by_length, lambda length: length // BIN)


def _binned(table: Mapping[int, Cases], bin_of: Callable[[int], int]) -> dict[int, list[Case]]:
    bins: dict[int, list[Case]] = {}
    for number, cases in table.items():
        bins.setdefault(bin_of(number), []).extend(cases)
    return bins


def _goals_label(place: int) -> str:
    return str(place) if place < _MANY else f"{_MANY}+"


def _length_label(place: int) -> str:
    return f"{place * BIN}–{place * BIN + BIN - 1}"


def _draw_panel(
    panel: Axes, name_of_bin: Callable[[int], str], series: Sequence[Bins], models: Sequence[str]
) -> None:
    panel.set_ylim(-3, 103)
    panel.grid(axis="y", color=RULE, linewidth=0.7)
    places = sorted({place for bins in series for place in bins})
    tasks = [max(len(bins.get(place, ())) for bins in series) for place in places]
    labels = [f"{name_of_bin(place)}\n{count}" for place, count in zip(places, tasks, strict=True)]
    panel.set_xticks(places, labels=labels, fontsize=7)
    panel.text(-0.03, -0.115, "tasks", transform=panel.transAxes, fontsize=7, ha="right", va="top")
    for number, (bins, model) in enumerate(zip(series, models, strict=True)):
        look = _Look(number, len(series))
        _draw_line(panel, bins, look, model)
        if len(series) <= _MOST_WITH_INTERVALS:
            _draw_intervals(panel, bins, look)


@dataclass(frozen=True, slots=True)
class _Look:
    """How the line of a model looks, which is one of so many."""

    number: int
    count: int

    @property
    def color(self) -> str:
        return LINES[self.number % len(LINES)]

    @property
    def mark(self) -> str:
        return _MARKS[self.number % len(_MARKS)]

    @property
    def style(self) -> str:
        return _STYLES[self.number // len(LINES) % len(_STYLES)]

    @property
    def shift(self) -> float:
        """How far its marks stand beside their place."""
        return _APART * (self.number - (self.count - 1) / 2) if self.count <= _MOST_WITH_INTERVALS else 0.0


def _draw_line(panel: Axes, bins: Bins, look: _Look, model: str) -> None:
    """A line with marks, broken where there are no tasks."""
    places = range(min(bins, default=0), max(bins, default=-1) + 1)
    percents = [rate_of(case.share for case in bins.get(place, ())).percent for place in places]
    heights = [math.nan if percent is None else percent for percent in percents]
    at = [place + look.shift for place in places]
    panel.plot(
        at, heights, look.mark + look.style, color=look.color, linewidth=1.1, markersize=4, label=model
    )
    few = [(x, y) for x, y, p in zip(at, heights, places, strict=True) if 0 < len(bins.get(p, ())) < _FEWEST]
    for x, y in few:
        panel.plot(x, y, look.mark, color=look.color, markerfacecolor="white", markersize=4, zorder=3)


def _draw_intervals(panel: Axes, bins: Bins, look: _Look) -> None:
    for place, cases in bins.items():
        certainty = certainty_of_rate(cases)
        if certainty is not None:
            panel.vlines(place + look.shift, *certainty.interval, color=look.color, linewidth=0.8, alpha=0.6)
