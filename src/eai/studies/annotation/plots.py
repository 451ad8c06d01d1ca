"""Histograms of ratings, an attribute a panel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.results.plots import ACCENT, INK, clipped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from eai.results.table import Table

_PANEL = (2.3, 2.0)
_COLUMNS = 3


def draw(tables: Sequence[Table]) -> Figure:
    """Draw the histograms of the tables of the analysis."""
    from matplotlib.figure import Figure

    attributes, scores = (table.by_name() for table in tables)
    columns = min(_COLUMNS, len(attributes))
    rows = -(-len(attributes) // columns)
    figure = Figure(figsize=(_PANEL[0] * columns, _PANEL[1] * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).flatten()
    for panel, each in zip(panels, attributes, strict=False):
        name = str(each["attribute"])
        counts = {row["score"]: row["ratings"] for row in scores if row["attribute"] == name}
        panel.set_title(clipped(name))
        panel.bar(list(counts), list(counts.values()), width=0.8, color=ACCENT)
        for score, count in counts.items():
            if count:
                panel.annotate(str(count), (score, count), ha="center", va="bottom", fontsize=6.5, color=INK)
        panel.set_xticks(list(counts))
        panel.set_xlabel(f"mean {each['mean']:.2f}, n = {each['ratings']}")
    for panel in panels[::columns]:
        panel.set_ylabel("ratings")
        panel.yaxis.get_major_locator().set_params(integer=True)
    for panel in panels[len(attributes) :]:
        panel.set_visible(False)
    return figure
