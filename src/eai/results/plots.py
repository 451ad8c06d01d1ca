"""Common parts of all plots: colours, labels, files, estimates with intervals, matrices and bands.

Success is green, a missed goal ochre, an unknown name or a wrong number of arguments violet.
`OUTCOME_COLORS` has a colour for each error that may end an answer.
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
from eai.base.errors import InputError, require_extra
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
MODEL_COLORS = (
    "#2f6690",
    "#bf5348",
    "#3f7f62",
    "#d8b455",
    "#8a64a0",
    "#e0905a",
    "#5d5f72",
    "#6f94bd",
    "#a3bf8f",
)
"""Line colours of the models in one plot, in order; repeated if there are more models."""


_MAX_LABEL_CHARACTERS = 30
_MAX_LABEL_LINES = 3
_LAST_FONT_CHARACTER = "\u058f"
"""Last Unicode character of the plots' font, which has Latin, Greek, Cyrillic and Armenian letters."""


def wrap_label(name: str) -> str:
    """Return a name as a label of up to three lines, so that a long name can be read in full."""
    return textwrap.fill(
        _replace_undrawable_characters(name),
        _MAX_LABEL_CHARACTERS,
        max_lines=_MAX_LABEL_LINES,
        placeholder="...",
    )


def clip_label(name: str) -> str:
    """Return a name as a short label on one line, with only characters of the plots' font."""
    text = _replace_undrawable_characters(name)
    return text if len(text) <= _MAX_LABEL_CHARACTERS else f"{text[: _MAX_LABEL_CHARACTERS - 3]}..."


def _replace_undrawable_characters(name: str) -> str:
    return "".join(c if c.isprintable() and c <= _LAST_FONT_CHARACTER else "?" for c in name)


_DOTS_PER_INCH = 150
_SAVE_OPTIONS: Mapping[str, Mapping[str, Any]] = {
    "svg": {"metadata": {"Date": None}},
    "png": {"metadata": {"Software": None}, "dpi": _DOTS_PER_INCH},
    "pdf": {"metadata": {"CreationDate": None, "Creator": None, "Producer": None}},
}
"""Mapping from each file format to matplotlib's options for saving, without date and program version."""

FORMATS = tuple(_SAVE_OPTIONS)
"""Names of the file formats; the first is written if a command's option `--formats` names none."""

_STYLE = "plots.mplstyle"
_TITLE_INCHES = 0.2
"""Height of a title in inches."""
_TITLE_MARGIN_INCHES = 0.04
"""Distance of a title from the top edge, in inches, in a figure that matplotlib does not lay out itself."""


def parse_formats(text: str) -> list[str]:
    """Return the file formats that the option `--formats` names, separated by commas.

    Raises:
        InputError: a format is unknown, or there is none.
    """
    names = {name.strip() for name in text.split(",")}
    if not names <= set(FORMATS):
        raise InputError(f"--formats: expected some of {', '.join(FORMATS)}, not {text!r}")
    return [name for name in FORMATS if name in names]


@contextmanager
def use_plot_style() -> Iterator[None]:
    """Use the style of all plots for figures that are drawn and written in the block.

    Raises:
        EaiError: matplotlib is not installed.
    """
    with require_extra("plots", "plots need"):
        import matplotlib as mpl
    style = resources.files("eai.results") / _STYLE
    with resources.as_file(style) as path, mpl.rc_context(fname=path):
        yield


def make_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, with a layout that fits its parts."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def make_canvas(
    size: tuple[float, float], x_limits: tuple[float, float], y_limits: tuple[float, float]
) -> tuple[Figure, Axes]:
    """Return an empty figure, and a panel without axes that fills it, for items with given coordinates.

    Args:
        size: width and height of the figure, in inches.
        x_limits: horizontal coordinates of the left and right edge.
        y_limits: vertical coordinates of the lower and upper edge.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size)
    panel = figure.add_axes((0, 0, 1, 1))
    panel.set_axis_off()
    shape = (size[1] / size[0]) * abs((x_limits[1] - x_limits[0]) / (y_limits[1] - y_limits[0]))
    panel.set(xlim=x_limits, ylim=y_limits, aspect=shape, anchor="S")
    return figure, panel


def add_title(figure: Figure, title: str) -> None:
    """Add a title above a figure and its caption; the figure becomes higher by the title's height."""
    width, height = figure.get_size_inches()
    figure.set_size_inches(width, height + _TITLE_INCHES)
    add_caption(figure, f"{title}\n{figure.get_suptitle()}".strip())


def add_caption(figure: Figure, text: str) -> None:
    """Add a text above a figure, aligned with its left edge. The text may use the whole width."""
    y = None if figure.get_layout_engine() else 1 - _TITLE_MARGIN_INCHES / figure.get_figheight()
    figure.suptitle(text, x=0.01, y=y, ha="left", va="top", fontsize=7.5)


def write_figure(
    figure: Figure, path: Path, formats: Sequence[str] = FORMATS, *, clips: bool = True
) -> tuple[Path, ...]:
    """Write a figure as a file of each format, without the date and the program's version.

    The layout is computed once, for a bitmap, and then used for all formats. Ligatures are off: for ligatures
    a PDF embeds a second font, and text search misses the letters.

    Args:
        figure: the figure.
        path: path without the extension.
        formats: the formats to write, from `FORMATS`.
        clips: whether parts outside the axes are cut off.
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
    for file_format in formats:
        figure.savefig(_make_figure_path(path, file_format), **_SAVE_OPTIONS[file_format])
    return tuple(_make_figure_path(path, file_format) for file_format in formats)


def _make_figure_path(path: Path, file_format: str) -> Path:
    return path.with_name(f"{path.name}.{file_format}")


COLUMN = 3.4
"""Width of a column of a page, in inches. Figures of this width show letters in their stated size."""

PAGE = 7.0
"""Width of a page's text in inches."""

FEW_CASES = 5
"""Minimum denominator of a rate that is drawn as a filled mark; below this number the mark is hollow."""

_MAX_NAMES = 30
_CELL_INCHES = 0.42
"""Width of a cell of a matrix in inches, if the page is wide enough."""

_COUNT_ROW = "n"
"""Label of the row with each model's denominator, drawn if all rates of a model have the same denominator."""

_EXTRA_LINE_HEIGHT = 0.65
"""Height of each further line of a label, as a multiple of the height of the first line."""

_LABEL_INCHES = 1.7
"""Width of the row labels and of both margins of a matrix, in inches."""

_DARK_PERCENT = 55.0
"""Rate in percent above which the letters in a cell are white instead of dark."""


def group_rows_by_suite(table: Table) -> dict[SuiteKey, list[dict[str, Cell]]]:
    """Return a mapping from protocol (rules), benchmark and ability to rows; a row maps columns to values."""
    return group_pairs((SuiteKey(*(str(row[name]) for name in SUITE)), row) for row in table.row_dicts())


def get_value_of_cell(cell: Cell | None) -> float:
    """Return the number in a table cell, or NaN if the cell has no estimate or its number is unknown."""
    return cell.value if isinstance(cell, Estimate) and cell.value is not None else math.nan


def get_denominator_of_cell(cell: Cell | None) -> int:
    """Return the denominator of a table cell, such as a number of tasks; 0 if the cell has no estimate."""
    return int(cell.denominator or 0) if isinstance(cell, Estimate) else 0


def get_numerator_of_cell(cell: Cell | None) -> int:
    """Return the numerator of a table cell, such as a number of successes; 0 if the cell has no estimate."""
    return int(cell.numerator or 0) if isinstance(cell, Estimate) else 0


def draw_estimate(panel: Axes, height: float, cell: Cell, color: str, fill: str) -> None:
    """Draw an estimate as a dot, with its interval as a horizontal line."""
    if not isinstance(cell, Estimate) or cell.value is None:
        return
    if cell.low is not None and cell.high is not None:
        panel.hlines(height, cell.low, cell.high, color=color, linewidth=1.0)
    panel.plot(cell.value, height, "o", color=color, markerfacecolor=fill, markersize=4, zorder=3)


def draw_line(
    panel: Axes,
    positions: Sequence[float],
    cells: Sequence[Cell],
    color: str,
    style: str = "o-",
    *,
    hollow: Collection[float] = (),
    intervals: bool = True,
    **properties: Any,
) -> None:
    """Draw a line through estimates, with their intervals; the line is broken at missing estimates.

    Args:
        panel: the panel to draw in.
        positions: positions of the estimates along the axis.
        cells: the estimates.
        color: colour of line, marks and intervals.
        style: matplotlib's format of mark and line.
        hollow: positions whose marks are hollow, because denominators are small.
        intervals: whether intervals are drawn.
        properties: further properties of the line.
    """
    properties = {"linewidth": 1.2, "markersize": 4, **properties}
    panel.plot(positions, [get_value_of_cell(cell) for cell in cells], style, color=color, **properties)
    for position, cell in zip(positions, cells, strict=True):
        if intervals and isinstance(cell, Estimate) and cell.low is not None and cell.high is not None:
            panel.vlines(position, cell.low, cell.high, color=color, linewidth=0.8)
        if position in hollow:
            mark = panel.plot(
                position, get_value_of_cell(cell), style[0], color=color, markersize=4, zorder=3
            )[0]
            mark.set_markerfacecolor("white")


def draw_rates_by_name(
    rows: Sequence[Mapping[str, Cell]], name_column: str, rate_column: str, axis_label: str
) -> Figure | None:
    """Draw one rate with its interval for each name in a column, such as the predicates of goals.

    Return None if all denominators are zero. Each name with a denominator has a line. Labels state the name's
    denominator, or its numerator if all names have the same denominator.

    Args:
        rows: the rows of a suite.
        name_column: the column of names.
        rate_column: the column of rates.
        axis_label: label of the axis of rates.
    """
    first = rows[0]["model"] if rows else None
    shown = [
        row for row in rows if row["model"] == first and not math.isnan(get_value_of_cell(row[rate_column]))
    ]
    shown = sorted(shown, key=lambda row: -get_denominator_of_cell(row[rate_column]))[:_MAX_NAMES]
    if not shown:
        return None
    shown.sort(key=lambda row: (-get_value_of_cell(row[rate_column]), str(row[name_column])))
    one_whole = len({get_denominator_of_cell(row[rate_column]) for row in shown}) == 1
    count_of = get_numerator_of_cell if one_whole else get_denominator_of_cell
    labels = [
        f"{wrap_label(str(row[name_column]).replace('_', ' '))}\u2002{count_of(row[rate_column]):,}"
        for row in shown
    ]
    heights = [1 + _EXTRA_LINE_HEIGHT * label.count("\n") for label in labels]
    ends = list(accumulate(heights))
    middles = [end - height / 2 for end, height in zip(ends, heights, strict=True)]
    figure = make_figure(COLUMN, 0.7 + 0.17 * ends[-1])
    panel = figure.subplots()
    for height, row in zip(middles, shown, strict=True):
        few = get_denominator_of_cell(row[rate_column]) < FEW_CASES
        draw_estimate(panel, height, row[rate_column], MUTED if few else ACCENT, "white" if few else ACCENT)
    panel.set_yticks(middles, labels=labels, fontsize=6.5, linespacing=1.0)
    panel.set_ylim(ends[-1], 0)
    panel.text(-0.02, 1, "n", transform=panel.transAxes, fontsize=6.5, ha="right", va="bottom")
    panel.set_xlim(-3, 103)
    panel.grid(axis="x", color=RULE, linewidth=0.6)
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    panel.set_xlabel(f"{axis_label}, percent", fontsize=7, loc="right")
    return figure


def draw_rate_matrix(
    rows: Sequence[Mapping[str, Cell]],
    label_columns: Sequence[str],
    rate_column: str,
    caption: str,
    *,
    other_axis_column: str = MODEL,
    shows_zero_rates: bool = False,
) -> Figure | None:
    """Draw a matrix of rates with models on one axis; return None if there are no rates.

    The labels of the other axis are the combined values of some columns (``label_columns``), such as
    outcomes. The longer axis is vertical, so that many models fit. Rates with small denominators are in
    brackets. If all rates of a model have the same denominator, this number stands at the end of the model's
    row or column.

    Args:
        rows: the rows of a suite.
        label_columns: the columns whose values together label a row (or column) of the matrix.
        rate_column: the column of rates.
        caption: caption of the matrix.
        other_axis_column: the column on the axis of the models; by default the models.
        shows_zero_rates: whether rates of zero are written as numbers; if not, their cells are blank.
    """
    cells = {
        (_make_row_label(row, label_columns), str(row[other_axis_column]).replace("_", " ")): row[rate_column]
        for row in rows
    }
    row_names, column_names = (list(dict.fromkeys(pair[axis] for pair in cells)) for axis in (0, 1))
    if not cells:
        return None
    is_turned = len(column_names) > len(row_names)
    case_counts = {
        column_name: {
            get_denominator_of_cell(cell) for (_, model), cell in cells.items() if model == column_name
        }
        for column_name in column_names
    }
    if all(len(counts) == 1 for counts in case_counts.values()):
        cells |= {(_COUNT_ROW, column_name): counts.pop() for column_name, counts in case_counts.items()}
        row_names.append(_COUNT_ROW)
    if is_turned:
        cells, row_names, column_names = (
            {(right, left): cell for (left, right), cell in cells.items()},
            column_names,
            row_names,
        )
    width = min(_CELL_INCHES * len(column_names), PAGE - _LABEL_INCHES)
    figure = make_figure(_LABEL_INCHES + width, 1.3 + 0.19 * len(row_names))
    panel = figure.subplots()
    grid = [[cells.get((name, column_name)) for column_name in column_names] for name in row_names]
    shades = [[get_value_of_cell(cell) for cell in line] for line in grid]
    panel.imshow(shades, vmin=0, vmax=100, cmap="Greys", aspect="auto")
    panel.set_xticks(
        range(len(column_names)), labels=map(clip_label, column_names), rotation=55, ha="right", fontsize=6.5
    )
    panel.set_yticks(range(len(row_names)), labels=map(clip_label, row_names), fontsize=6.5)
    add_caption(figure, caption)
    panel.tick_params(length=0)
    panel.spines[:].set_visible(False)
    for y, line in enumerate(grid):
        for x, cell in enumerate(line):
            value = get_value_of_cell(cell)
            if isinstance(cell, int) or value > 0 or (shows_zero_rates and value == 0):
                color = "white" if value > _DARK_PERCENT else INK
                style = {"ha": "center", "va": "center", "color": color, "fontsize": 6, "in_layout": False}
                figure.text(x, y, _format_cell_number(cell), style, transform=panel.transData)
    if any(text.get_text().startswith("(") for text in figure.texts):
        figure.supxlabel(f"in brackets: of fewer than {FEW_CASES}", x=0.01, ha="left", fontsize=6)
    return figure


def _format_cell_number(cell: Cell | None) -> str:
    if isinstance(cell, int):
        return f"{cell:,}"
    value = get_value_of_cell(cell)
    text = "<1" if 0 < value <= 0.5 else f"{value:.0f}"
    return f"({text})" if get_denominator_of_cell(cell) < FEW_CASES else text


def _make_row_label(row: Mapping[str, Cell], levels: Sequence[str]) -> str:
    parts = [str(row[level]).replace("_", " ") for level in levels if row[level]]
    return ", ".join(parts[1:] or parts) if len(levels) > 1 else parts[0]


def draw_flow_band(
    panel: Axes,
    left_x: float,
    heights_and_thickness: tuple[float, float, float],
    color: str,
    alpha: float = 0.9,
) -> None:
    """Draw a curved band from one stage to the next, as in a flow diagram.

    Args:
        panel: the panel to draw in; the caller sets its limits.
        left_x: horizontal coordinate of the first stage; that of the next stage is larger by one.
        heights_and_thickness: height at the first stage, height at the next stage, and thickness, in percent.
        color: colour of the band.
        alpha: opacity, from 0 to 1.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    left, right, bend = left_x, left_x + 1.0, 0.5
    low, low_end, thickness = heights_and_thickness
    high, high_end = low + thickness, low_end + thickness
    across = (left, left + bend, right - bend, right)
    below, above = (low, low, low_end, low_end), (high, high, high_end, high_end)
    lower_edge, upper_edge = zip(across, below, strict=True), zip(across, above, strict=True)
    points = [*lower_edge, *reversed([*upper_edge]), (left, low)]
    curve = [Path.CURVE4] * 3
    codes = [Path.MOVETO, *curve, Path.LINETO, *curve, Path.CLOSEPOLY]
    panel.add_artist(PathPatch(Path(points, codes), facecolor=color, linewidth=0, alpha=alpha))
