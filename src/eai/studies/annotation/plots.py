"""Histograms of ratings, an attribute a panel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from eai.results.plots import ACCENT, INK, clipped
from eai.studies.annotation.ratings import Quality

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANEL = (2.3, 2.0)
_COLUMNS = 3


def draw(found: Sequence[Quality]) -> Figure:
    """Draw the histograms."""
    from matplotlib.figure import Figure

    columns = min(_COLUMNS, len(found))
    rows = -(-len(found) // columns)
    figure = Figure(figsize=(_PANEL[0] * columns, _PANEL[1] * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharey=True).flatten()
    for panel, each in zip(panels, found, strict=False):
        panel.set_title(clipped(each.attribute))
        panel.bar(list(each.histogram), list(each.histogram.values()), width=0.8, color=ACCENT)
        for score, count in each.histogram.items():
            if count:
                panel.annotate(str(count), (score, count), ha="center", va="bottom", fontsize=6.5, color=INK)
        panel.set_xticks(list(each.histogram))
        panel.set_xlabel(f"mean {each.mean:.2f}, n = {each.ratings}")
    for panel in panels[::columns]:
        panel.set_ylabel("ratings")
        panel.yaxis.get_major_locator().set_params(integer=True)
    for panel in panels[len(found) :]:
        panel.set_visible(False)
    return figure
