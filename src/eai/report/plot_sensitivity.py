"""Heat map: how often a problem can still be solved with one operator of the answer among gold ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from eai.abilities.declaration import label_of
from eai.analysis.sensitivity import Sensitivity
from eai.report.plot_files import styled, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_CELL = (0.62, 0.27)
_MARGIN = (2.6, 1.5)
_DARK = 45.0
"""Percent below which a cell is too dark for dark letters."""


def save(sensitivity: Sensitivity, title: str, path: Path) -> tuple[Path, ...]:
    """Write the heat map as ``path``.svg and ``path``.png; returns what was written.

    Raises:
        EaiError: matplotlib is not installed.
    """
    with styled():
        figure = draw(sensitivity, title)
        return () if figure is None else write(figure, path)


def draw(sensitivity: Sensitivity, title: str) -> Figure | None:
    """An operator a row, a category a column, each cell with percent and attempts; None if none."""
    from matplotlib.figure import Figure

    rows, columns = len(sensitivity.operators), len(sensitivity.rates)
    if not rows:
        return None
    size = (_MARGIN[0] + 2 * _CELL[0] * columns, _MARGIN[1] + _CELL[1] * rows)
    figure = Figure(figsize=size, layout="constrained")
    panel = figure.subplots()
    values = [
        [_percent(sensitivity, row, operator) for row in sensitivity.rates]
        for operator in sensitivity.operators
    ]
    image = panel.imshow(values, vmin=0, vmax=100, cmap="viridis", aspect="auto")
    panel.set_title(title)
    panel.set_xticks(
        range(columns), labels=[label_of(row) for row in sensitivity.rates], rotation=20, ha="right"
    )
    panel.set_yticks(range(rows), labels=list(sensitivity.operators))
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    _write_cells(panel, sensitivity)
    figure.colorbar(image, ax=panel, label="solved, percent", shrink=0.6)
    return figure


def _percent(sensitivity: Sensitivity, row: str, operator: str) -> float:
    rate = sensitivity.rates[row].get(operator)
    return float("nan") if rate is None or rate.percent is None else rate.percent


def _write_cells(panel: Axes, sensitivity: Sensitivity) -> None:
    for x, rates in enumerate(sensitivity.rates.values()):
        for y, operator in enumerate(sensitivity.operators):
            rate = rates.get(operator)
            if rate is None or rate.percent is None:
                continue
            color = "white" if rate.percent < _DARK else "black"
            text = f"{rate.percent:.0f}  n={rate.denominator:g}"
            panel.text(x, y, text, ha="center", va="center", color=color, fontsize=7)
