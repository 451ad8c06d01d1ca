"""The common parts of all plots: colours, names as labels, files, estimates with intervals, matrices, bands.

Rights are green, misses ochre, errors of words violet, of steps warm.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import resources
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eai.abilities.declaration import AnswerOutcome
from eai.base.errors import require_extra
from eai.base.grouping import group_pairs
from eai.results.lines import MODEL, SUITE, SuiteKey
from eai.results.table import Cell, Estimate, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OUTCOME_COLORS = {
    AnswerOutcome.SUCCESS: "#3f7f62",
    AnswerOutcome.PARTLY_RIGHT: "#a3bf8f",
    AnswerOutcome.GOAL_MISSED: "#d8b455",
    AnswerOutcome.PARSING: "#5d5f72",
    AnswerOutcome.HALLUCINATION: "#8a64a0",
    AnswerOutcome.ARGUMENT_NUMBER: "#b99cc8",
    AnswerOutcome.AFFORDANCE: "#e0905a",
    AnswerOutcome.MISSING_STEP: "#bf5348",
    AnswerOutcome.WRONG_ORDER: "#6f94bd",
    AnswerOutcome.ADDITIONAL_STEP: "#a9a9a2",
    AnswerOutcome.UNCATEGORISED: "#c9c6bd",
    AnswerOutcome.SLIP: "#7fb5b5",
    AnswerOutcome.NOT_ANSWERED: "#b8a98c",
    AnswerOutcome.EXCLUDED: "#e6e3db",
}
INK = "#2b2d33"
SOFT = "#55575e"
MUTED = "#8b8d94"
RULE = "#dcdad3"
ACCENT = "#2f6690"
LINES = ("#2f6690", "#bf5348", "#3f7f62", "#d8b455", "#8a64a0", "#e0905a", "#5d5f72", "#6f94bd", "#a3bf8f")
"""The colours of models that share an axis, used again from the start if there are more."""


_LONGEST = 30
_MOST_LINES = 3
_LAST_LETTER = "\u058f"
"""The plots' font has the letters up to here (Latin, Greek, Cyrillic, Armenian)."""


def wrap_label(name: str) -> str:
    """A name as a label of up to three lines, so that a check's can be read in full."""
    return textwrap.fill(_drawable(name), _LONGEST, max_lines=_MOST_LINES, placeholder="...")


def clip_label(name: str) -> str:
    """A name as a label: one short line of characters that the plots' font has."""
    text = _drawable(name)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _drawable(name: str) -> str:
    return "".join(c if c.isprintable() and c <= _LAST_LETTER else "?" for c in name)


_DOTS_PER_INCH = 150
_HOW: Mapping[str, Mapping[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "png": {"metadata": {"Software": None}, "dpi": _DOTS_PER_INCH},
    "pdf": {"metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
}
"""How a format is written: without the day and the program's version."""

FORMATS = tuple(_HOW)
_STYLE = "plots.mplstyle"
_TITLE = 0.2
"""The height of a title, in inches."""
_EDGE = 0.04
"""How far it is from the edge of a figure that is not laid out."""


@contextmanager
def use_plot_style() -> Iterator[None]:
    """Within it, figures are drawn and written in the style of all plots.

    Raises:
        EaiError: matplotlib is not installed.
    """
    with require_extra("plots", "plots need"):
        import matplotlib as mpl
    style = resources.files("eai.results") / _STYLE
    with resources.as_file(style) as path, mpl.rc_context(fname=path):
        yield


def make_figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches, whose parts are given the room that they need."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def make_canvas(
    size: tuple[float, float], across: tuple[float, float], up: tuple[float, float]
) -> tuple[Figure, Axes]:
    """An empty figure, and all of it as one panel without axes: what is placed in it needs no layout.

    Args:
        size: width and height of the figure, in inches.
        across: the coordinates of its left and right edge.
        up: those of its lower and upper edge.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size)
    panel = figure.add_axes((0, 0, 1, 1))
    panel.set_axis_off()
    shape = (size[1] / size[0]) * abs((across[1] - across[0]) / (up[1] - up[0]))
    panel.set(xlim=across, ylim=up, aspect=shape, anchor="S")
    return figure, panel


def add_title(figure: Figure, title: str) -> None:
    """Say above a figure, and above what it says there of itself, what it is of; it grows by as much."""
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + _TITLE)
    add_caption(figure, f"{title}\n{figure.get_suptitle()}".strip())


def add_caption(figure: Figure, text: str) -> None:
    """Say something above a figure, from its left edge on, where there is the room of all of its width."""
    y = None if figure.get_layout_engine() else 1 - _EDGE / figure.get_figheight()
    figure.suptitle(text, x=0.01, y=y, ha="left", va="top", fontsize=7.5)


def write(
    figure: Figure, path: Path, formats: Sequence[str] = FORMATS, *, clips: bool = True
) -> tuple[Path, ...]:
    """Write a figure as ``path.svg`` and so on, without the date and the program's version.

    It is laid out once, as a picture of dots. No letters are joined: for joined ones a PDF embeds a second
    font, and a search of its text misses them.

    Args:
        figure: the figure.
        path: where to, without the ending.
        formats: those of `FORMATS` that are wanted.
        clips: whether what leaves its axes is cut off.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text

    artists = figure.findobj()
    for text in artists:
        if isinstance(text, Text) and hasattr(text, "set_fontfeatures"):
            text.set_fontfeatures(("-liga",))
    figure.dpi = _DOTS_PER_INCH
    FigureCanvasAgg(figure)
    if (engine := figure.get_layout_engine()) is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    for artist in () if clips else artists:
        artist.set_clip_on(False)
    for kind in formats:
        figure.savefig(_target(path, kind), **_HOW[kind])
    return tuple(_target(path, kind) for kind in formats)


def _target(path: Path, kind: str) -> Path:
    return path.with_name(f"{path.name}.{kind}")


COLUMN = 3.4
"""The width of a column of a page, in inches, so that letters have the size that they say."""

PAGE = 7.0
"""The width of a page's text, in inches."""

FEW_CASES = 5
"""Fewer cases than this say little: their marks are hollow."""

_MOST_NAMES = 30
_FIELD = 0.42
"""The width of a field of a matrix, in inches, where the page is wide enough."""

_WHOLE = "n"
"""The name of the number of cases where all rates of a model are of the same ones."""

_MORE_LINE = 0.65
"""How much higher than a line of a name the next one makes it."""

_LABELS = 1.7
"""The width that names of rows and the edges take, in inches."""

_DARK = 55.0
"""Percent above which a field is too dark for dark letters."""


def rows_of(table: Table) -> dict[SuiteKey, list[dict[str, Cell]]]:
    """The rows of a table by suite, as the values of their columns."""
    return group_pairs((SuiteKey(*(str(row[name]) for name in SUITE)), row) for row in table.row_dicts())


def value_of(cell: Cell | None) -> float:
    """The number of an estimate; not a number where there is none."""
    return cell.value if isinstance(cell, Estimate) and cell.value is not None else math.nan


def denominator_of(cell: Cell | None) -> int:
    """Of how many cases an estimate is."""
    return int(cell.denominator or 0) if isinstance(cell, Estimate) else 0


def numerator_of(cell: Cell | None) -> int:
    """How many of these count."""
    return int(cell.numerator or 0) if isinstance(cell, Estimate) else 0


def draw_estimate(panel: Axes, place: float, cell: Cell, color: str, fill: str) -> None:
    """A dot at a height, with its interval."""
    if not isinstance(cell, Estimate) or cell.value is None:
        return
    if cell.low is not None and cell.high is not None:
        panel.hlines(place, cell.low, cell.high, color=color, linewidth=1.0)
    panel.plot(cell.value, place, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)


def draw_line(
    panel: Axes,
    places: Sequence[float],
    cells: Sequence[Cell],
    color: str,
    style: str = "o-",
    *,
    hollow: Collection[float] = (),
    intervals: bool = True,
    **look: Any,
) -> None:
    """A line through estimates, broken where there is none, with their intervals.

    Args:
        panel: where.
        places: where they are along the axis.
        cells: the estimates.
        color: of all of it.
        style: the mark and the kind of line, as matplotlib writes them.
        hollow: the places of which the mark is hollow, as it is of few cases.
        intervals: whether intervals are drawn.
        look: further properties of the line.
    """
    look = {"linewidth": 1.2, "markersize": 4, **look}
    panel.plot(places, [value_of(cell) for cell in cells], style, color=color, **look)
    for place, cell in zip(places, cells, strict=True):
        if intervals and isinstance(cell, Estimate) and cell.low is not None and cell.high is not None:
            panel.vlines(place, cell.low, cell.high, color=color, linewidth=0.8)
        if place in hollow:
            mark = panel.plot(place, value_of(cell), style[0], color=color, markersize=4, zorder=3)[0]
            mark.set_markerfacecolor("white")


def draw_names(rows: Sequence[Mapping[str, Cell]], column: str, rate: str, label: str) -> Figure | None:
    """Rates by name with intervals, a line a name; None if there are none. A name of no cases has no line.

    Beside each name stands its number of cases; where all names share in the same ones, how many it has.

    Args:
        rows: those of a suite.
        column: the column of the names.
        rate: that of the rates.
        label: what the rates are.
    """
    first = rows[0]["model"] if rows else None
    shown = [row for row in rows if row["model"] == first and not math.isnan(value_of(row[rate]))]
    shown = sorted(shown, key=lambda row: -denominator_of(row[rate]))[:_MOST_NAMES]
    if not shown:
        return None
    shown.sort(key=lambda row: (-value_of(row[rate]), str(row[column])))
    one_whole = len({denominator_of(row[rate]) for row in shown}) == 1
    made_of = numerator_of if one_whole else denominator_of
    labels = [
        f"{wrap_label(str(row[column]).replace('_', ' '))}\u2002{made_of(row[rate]):,}" for row in shown
    ]
    heights = [1 + _MORE_LINE * label.count("\n") for label in labels]
    ends = list(accumulate(heights))
    places = [end - height / 2 for end, height in zip(ends, heights, strict=True)]
    figure = make_figure(COLUMN, 0.7 + 0.17 * ends[-1])
    panel = figure.subplots()
    for place, row in zip(places, shown, strict=True):
        few = denominator_of(row[rate]) < FEW_CASES
        draw_estimate(panel, place, row[rate], MUTED if few else ACCENT, "white" if few else ACCENT)
    panel.set_yticks(places, labels=labels, fontsize=6.5, linespacing=1.0)
    panel.set_ylim(ends[-1], 0)
    panel.text(-0.02, 1, "n", transform=panel.transAxes, fontsize=6.5, ha="right", va="bottom")
    panel.set_xlim(-3, 103)
    panel.grid(axis="x", color=RULE, linewidth=0.6)
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    panel.set_xlabel(f"{label}, percent", fontsize=7, loc="right")
    return figure


def draw_matrix(
    rows: Sequence[Mapping[str, Cell]],
    levels: Sequence[str],
    rate: str,
    label: str,
    *,
    across: str = MODEL,
    zeros: bool = False,
) -> Figure | None:
    """Rates as a matrix of names and models with the numbers in it; None if there are none.

    What there is more of stands below each other, so that many models fit a page. Numbers of few cases are in
    brackets; where all of a model are of the same cases, their number stands at its end.

    Args:
        rows: those of a suite.
        levels: the columns whose values together are the names.
        rate: that of the rates.
        label: what they are.
        across: the column whose values stand in the place of models.
        zeros: whether zero is written too, so that only what is of nothing is blank.
    """
    cells = {(_name(row, levels), str(row[across]).replace("_", " ")): row[rate] for row in rows}
    down, along = (list(dict.fromkeys(pair[place] for pair in cells)) for place in (0, 1))
    if not cells:
        return None
    turned = len(along) > len(down)
    wholes = {
        other: {denominator_of(cell) for (_, model), cell in cells.items() if model == other}
        for other in along
    }
    if all(len(whole) == 1 for whole in wholes.values()):
        cells |= {(_WHOLE, other): whole.pop() for other, whole in wholes.items()}
        down.append(_WHOLE)
    if turned:
        cells, down, along = {(right, left): cell for (left, right), cell in cells.items()}, along, down
    width = min(_FIELD * len(along), PAGE - _LABELS)
    figure = make_figure(_LABELS + width, 1.3 + 0.19 * len(down))
    panel = figure.subplots()
    grid = [[cells.get((name, other)) for other in along] for name in down]
    shades = [[value_of(cell) for cell in line] for line in grid]
    panel.imshow(shades, vmin=0, vmax=100, cmap="Greys", aspect="auto")
    panel.set_xticks(range(len(along)), labels=map(clip_label, along), rotation=55, ha="right", fontsize=6.5)
    panel.set_yticks(range(len(down)), labels=map(clip_label, down), fontsize=6.5)
    add_caption(figure, label)
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    for y, line in enumerate(grid):
        for x, cell in enumerate(line):
            value = value_of(cell)
            if isinstance(cell, int) or value > 0 or (zeros and value == 0):
                color = "white" if value > _DARK else INK
                style = {"ha": "center", "va": "center", "color": color, "fontsize": 6, "in_layout": False}
                figure.text(x, y, _number_text(cell), style, transform=panel.transData)
    if any(text.get_text().startswith("(") for text in figure.texts):
        figure.supxlabel(f"in brackets: of fewer than {FEW_CASES}", x=0.01, ha="left", fontsize=6)
    return figure


def _number_text(cell: Cell | None) -> str:
    if isinstance(cell, int):
        return f"{cell:,}"
    value = value_of(cell)
    text = f"{value:.0f}" if value >= 0.5 or not value else "<1"
    return f"({text})" if denominator_of(cell) < FEW_CASES else text


def _name(row: Mapping[str, Cell], levels: Sequence[str]) -> str:
    parts = [str(row[level]).replace("_", " ") for level in levels if row[level]]
    return ", ".join(parts[1:] or parts) if len(levels) > 1 else parts[0]


def draw_band(
    panel: Axes, stage: float, band: tuple[float, float, float], color: str, alpha: float = 0.9
) -> None:
    """A bent band from one stage to the next.

    Args:
        panel: where; its limits are set elsewhere.
        stage: the first of the two, as a coordinate; the next is larger by one.
        band: its height there, its height at the next one, and its thickness, in percent.
        color: its colour.
        alpha: how opaque it is, from 0 to 1.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    left, right, bend = stage, stage + 1.0, 0.5
    low, low_end, thickness = band
    high, high_end = low + thickness, low_end + thickness
    across = (left, left + bend, right - bend, right)
    below, above = (low, low, low_end, low_end), (high, high, high_end, high_end)
    there, back = zip(across, below, strict=True), zip(across, above, strict=True)
    points = [*there, *reversed([*back]), (left, low)]
    curve = [Path.CURVE4] * 3
    codes = [Path.MOVETO, *curve, Path.LINETO, *curve, Path.CLOSEPOLY]
    panel.add_artist(PathPatch(Path(points, codes), facecolor=color, linewidth=0, alpha=alpha))
