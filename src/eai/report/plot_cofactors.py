"""Success against what tasks are like, and how much of each feature is left beside the others."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.analysis.suites import SuiteKey
from eai.analysis.table import Cell, Estimate, Table
from eai.report.palette import ACCENT, INK, MUTED, RULE
from eai.report.plot_text import clipped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = (
    "annotated_steps",
    "annotated_operators",
    "ground_relation_goals",
    "ground_state_goals",
    "objects",
    "quantified_goals",
)
"""The features that are drawn; the table has them all."""

_PER_ROW = 2
_PANEL = (3.4, 1.9)
_EFFECT_ROW = 0.3
_MOST_NAMES = 30

Row = Sequence[Cell]


def rows_of(table: Table) -> dict[SuiteKey, list[dict[str, Cell]]]:
    """The rows of a table by suite, as the values of their columns."""
    found: dict[SuiteKey, list[dict[str, Cell]]] = {}
    for row in table.rows:
        values = dict(zip(table.columns, row, strict=True))
        suite = SuiteKey(str(values["protocol"]), str(values["domain"]), str(values["ability"]))
        found.setdefault(suite, []).append(values)
    return found


def draw_curves(rows: Sequence[Mapping[str, Cell]], label: str) -> Figure | None:
    """Success by feature, a panel a feature: all models together with intervals, each of them as a thin line.

    None if no feature is known.
    """
    from matplotlib.figure import Figure

    shown = [name for name in SHOWN if any(row["feature"] == name for row in rows)]
    if not shown:
        return None
    lines = -(-len(shown) // _PER_ROW)
    figure = Figure(figsize=(_PANEL[0] * _PER_ROW, _PANEL[1] * lines), layout="constrained")
    grid = figure.subplots(lines, _PER_ROW, squeeze=False, sharey=True)
    for place, panel in enumerate(grid.flat):
        if place < len(shown):
            _draw_feature(panel, shown[place], [row for row in rows if row["feature"] == shown[place]])
        else:
            panel.set_axis_off()
    for panels in grid:
        panels[0].set_ylabel(label)
    return figure


def _draw_feature(panel: Axes, feature: str, rows: Sequence[Mapping[str, Cell]]) -> None:
    panel.set_ylim(-4, 104)
    panel.grid(axis="y", color=RULE, linewidth=0.6)
    panel.set_title(feature.replace("_", " "), fontsize=8.5)
    bins = sorted({(int(str(row["from"])), int(str(row["to"]))) for row in rows})
    places = {low: number for number, (low, _) in enumerate(bins)}
    first = rows[0]["model"]
    for model in dict.fromkeys(row["model"] for row in rows):
        of_model = [row for row in rows if row["model"] == model]
        if model != first:
            _draw_line(panel, places, of_model)
    tasks = _draw_first(panel, places, [row for row in rows if row["model"] == first])
    labels = [f"{_bin(low, high)}\n{tasks.get(low, '')}" for low, high in bins]
    panel.set_xticks(range(len(bins)), labels=labels, fontsize=6.5)
    panel.text(-0.02, -0.17, "tasks", transform=panel.transAxes, fontsize=6.5, ha="right", va="top")


def _draw_line(panel: Axes, places: Mapping[int, int], rows: Sequence[Mapping[str, Cell]]) -> None:
    heights = dict.fromkeys(range(len(places)), math.nan)
    for row in rows:
        heights[places[int(str(row["from"]))]] = _value(row["score"])
    panel.plot(list(heights), list(heights.values()), color=MUTED, linewidth=0.6, alpha=0.55)


def _draw_first(panel: Axes, places: Mapping[int, int], rows: Sequence[Mapping[str, Cell]]) -> dict[int, int]:
    """Draw the line that is meant to be read; returns how many tasks each bin has."""
    heights, tasks = dict.fromkeys(range(len(places)), math.nan), {}
    for row in rows:
        low, score = int(str(row["from"])), row["score"]
        place, tasks[low] = places[low], int(str(row["tasks"]))
        heights[place] = _value(score)
        if isinstance(score, Estimate) and score.low is not None and score.high is not None:
            panel.vlines(place, score.low, score.high, color=INK, linewidth=1.0)
    panel.plot(list(heights), list(heights.values()), color=INK, linewidth=1.4)
    for row in rows:
        fill = "white" if row["few"] else INK
        panel.plot(
            places[int(str(row["from"]))],
            _value(row["score"]),
            "o",
            color=INK,
            markerfacecolor=fill,
            markersize=4,
            zorder=3,
        )
    return tasks


def _bin(low: int, high: int) -> str:
    return str(low) if low == high else f"{low:,}–{high:,}"


def _value(cell: Cell) -> float:
    return cell.value if isinstance(cell, Estimate) and cell.value is not None else math.nan


def draw_effects(rows: Sequence[Mapping[str, Cell]]) -> Figure | None:
    """The log odds of each feature, alone (hollow) and beside the others (filled); None if there are none."""
    from matplotlib.figure import Figure

    if not rows:
        return None
    figure = Figure(figsize=(_PANEL[0], 1.0 + _EFFECT_ROW * len(rows)), layout="constrained")
    panel = figure.subplots()
    panel.axvline(0, color=MUTED, linewidth=0.8)
    for place, row in enumerate(rows):
        _draw_estimate(panel, place - 0.14, row["alone"], MUTED, "white")
        _draw_estimate(panel, place + 0.14, row["together"], INK, INK)
    panel.set_yticks(
        range(len(rows)), labels=[str(row["feature"]).replace("_", " ") for row in rows], fontsize=7
    )
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    panel.set_xlabel("log odds of success per standard deviation\n○ alone   ● beside the others", fontsize=7)
    return figure


def _draw_estimate(panel: Axes, place: float, cell: Cell, color: str, fill: str) -> None:
    if not isinstance(cell, Estimate) or cell.value is None:
        return
    if cell.low is not None and cell.high is not None:
        panel.hlines(place, cell.low, cell.high, color=color, linewidth=1.0)
    panel.plot(cell.value, place, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)


def draw_names(rows: Sequence[Mapping[str, Cell]], column: str, rate: str, label: str) -> Figure | None:
    """Rates by name with intervals, a line a name with its number of cases; None if there are none.

    Args:
        rows: those of a suite.
        column: the column of the names.
        rate: that of the rates.
        label: what the rates are.
    """
    from matplotlib.figure import Figure

    first = rows[0]["model"] if rows else None
    shown = [row for row in rows if row["model"] == first and isinstance(row[rate], Estimate)]
    shown = sorted(shown, key=lambda row: -_cases(row[rate]))[:_MOST_NAMES]
    if not shown:
        return None
    shown.sort(key=lambda row: (-_value(row[rate]), str(row[column])))
    figure = Figure(figsize=(_PANEL[0], 0.7 + 0.17 * len(shown)), layout="constrained")
    panel = figure.subplots()
    for place, row in enumerate(shown):
        few = _cases(row[rate]) < 5
        _draw_estimate(panel, place, row[rate], MUTED if few else ACCENT, "white" if few else ACCENT)
    labels = [f"{clipped(str(row[column]))}  {_cases(row[rate]):g}" for row in shown]
    panel.set_yticks(range(len(shown)), labels=labels, fontsize=6.5)
    panel.set_ylim(len(shown) - 0.5, -0.5)
    panel.set_xlim(-3, 103)
    panel.grid(axis="x", color=RULE, linewidth=0.6)
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    panel.set_xlabel(f"{label}, percent", fontsize=7, loc="right")
    return figure


def _cases(cell: Cell) -> float:
    return (cell.denominator or 0) if isinstance(cell, Estimate) else 0
