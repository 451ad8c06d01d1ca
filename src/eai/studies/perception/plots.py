"""A metric against the realised predicate error rate: a point a run, both with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from eai.results.plots import ACCENT, COLUMN, MUTED, RULE, cases_of
from eai.results.table import Estimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.results.table import Table


def draw(by_run: Table, metric: str) -> Figure | None:
    """The points of all runs of which it is known what was perceived; the plain run is at 0, hollow."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(COLUMN, 2.6), layout="constrained")
    panel = figure.subplots()
    cases = set[int]()
    for row in by_run.rows:
        rate, value = row[1], row[-1]
        if not isinstance(rate, Estimate) or not isinstance(value, Estimate) or value.value is None:
            continue
        is_seen = rate.value is not None
        if not is_seen and row[0] != "text":
            continue
        cases.add(cases_of(value))
        place, color = rate.value or 0.0, ACCENT if is_seen else MUTED
        if value.low is not None and value.high is not None:
            panel.vlines(place, value.low, value.high, color=color, linewidth=1.0)
        if rate.low is not None and rate.high is not None:
            panel.hlines(value.value, rate.low, rate.high, color=color, linewidth=0.7)
        fill = color if is_seen else "white"
        panel.plot(place, value.value, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)
    of = " to ".join(f"{number:,}" for number in sorted({min(cases), max(cases)})) if cases else "0"
    panel.set_xlabel(f"facts missing or misplaced, percent (n = {of})")
    panel.set_ylabel(f"{metric.replace('_', ' ')} in percent")
    panel.set_ylim(0, 102)
    panel.set_xlim(left=-2)
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    return figure
