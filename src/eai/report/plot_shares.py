"""Heat maps of shares by action and by predicate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.metrics.rate import Rate
from eai.report.palette import INK
from eai.report.plot_text import clipped
from eai.report.run_summary import RunSummary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FEWEST = 5
"""Fewer cases than this say little: their fields are pale."""

_MOST_NAMES = 45
_MAP = ("#f6efe6", "#e8c78e", "#8fae8b", "#2f6b57")
_ROW = 0.2
_COLUMN = 0.42


def draw_names(runs: Sequence[RunSummary]) -> Figure | None:
    """Heat maps of the shares by action and by predicate, a column a model; None if neither is known."""
    from matplotlib.figure import Figure

    tables = [
        ("by action", [item.breakdown.by_action for item in runs]),
        ("by predicate", [item.breakdown.by_predicate for item in runs]),
    ]
    tables = [(title, columns) for title, columns in tables if any(columns)]
    if not tables:
        return None
    names = [_most_frequent(columns) for _, columns in tables]
    height = _ROW * max(map(len, names)) + 1.9
    width = (_COLUMN * len(runs) + 2.1) * len(tables) + 0.4
    figure = Figure(figsize=(width, height), layout="constrained")
    grid = figure.subplots(1, len(tables), squeeze=False)
    for panel, (title, columns), rows in zip(grid[0], tables, names, strict=True):
        panel.set_title(title)
        _draw_map(panel, rows, columns, [clipped(item.key.model) for item in runs])
    return figure


def _most_frequent(columns: Sequence[Mapping[str, Rate]]) -> list[str]:
    """The names with most cases, in order; answers can have any number of names of their own."""
    cases: dict[str, float] = {}
    for column in columns:
        for name, rate in column.items():
            cases[name] = cases.get(name, 0) + rate.denominator
    return sorted(sorted(cases, key=lambda name: (-cases[name], name))[:_MOST_NAMES])


def _draw_map(
    panel: Axes, names: Sequence[str], columns: Sequence[Mapping[str, Rate]], models: Sequence[str]
) -> None:
    from matplotlib.colors import LinearSegmentedColormap

    colors = LinearSegmentedColormap.from_list("eai", _MAP)
    panel.set_xlim(-0.5, len(columns) - 0.5)
    panel.set_ylim(len(names) - 0.5, -0.5)
    panel.set_yticks(range(len(names)), labels=[clipped(name) for name in names], fontsize=6.2)
    panel.set_xticks(range(len(models)), labels=models, rotation=60, ha="right", fontsize=6.2)
    panel.tick_params(length=0)
    for spine in panel.spines.values():
        spine.set_visible(False)
    values = [[_share(column, name) for column in columns] for name in names]
    strength = [[_strength(column, name) for column in columns] for name in names]
    panel.imshow(values, cmap=colors, vmin=0, vmax=100, aspect="auto", alpha=strength)
    for y, name in enumerate(names):
        for x, column in enumerate(columns):
            rate = column.get(name)
            if rate is not None and rate.percent is not None:
                color = "white" if rate.percent > 65 and rate.denominator >= _FEWEST else INK
                panel.text(x, y, f"{rate.percent:.0f}", fontsize=5.6, ha="center", va="center", color=color)


def _share(column: Mapping[str, Rate], name: str) -> float:
    percent = column[name].percent if name in column else None
    return float("nan") if percent is None else percent


def _strength(column: Mapping[str, Rate], name: str) -> float:
    return 0.35 if name in column and column[name].denominator < _FEWEST else 1.0
