"""Draw a page with one model's main results, reached goals and errors, by domain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import GRAMMAR, RUNTIME, MetricColumn
from eai.abilities.protocol import Ability, Protocol
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results.plots import MODEL_COLORS, MUTED, PAGE, RULE, clip_label, make_figure
from eai.studies.report.rankings import RankedModel, Ranking
from eai.studies.report.table_specs import format_ability_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKS = "osD^v"
_LINE = 0.19
"""Height of a panel's line, which shows one metric, in inches."""

_HEAD = 0.5
"""Height of a panel's title and margins, without the lines of its metrics (`_LINE`), in inches."""

_FOOT = 0.75
"""Height of the page's title and legend, in inches."""

_APART = 0.3
"""Vertical distance between the marks of two domains on one line, as a share of the line's height."""


_PLANS = [
    f"{ability.value}_trajectory" for ability in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
]
_PANELS: Sequence[tuple[str, Sequence[str], Sequence[str]]] = (
    ("Main results, percent", ["overview"], ()),
    ("Goals that its plans reach, percent", ["goal_satisfaction"], ()),
    ("What goes wrong in its plans, percent of answers", _PLANS, (GRAMMAR, RUNTIME)),
)
"""Contents of each panel: its title, names of tables, and the groups of columns that it shows.

A group of columns is, for example, the runtime errors. An empty list means all groups.
"""

_RankedRowsByPanelMetric: TypeAlias = Mapping[tuple[str, MetricColumn], Sequence[tuple[Ranking, RankedModel]]]
"""Lines of a panel, one for each rate of the model, with a dot for each domain.

The key of a line is the heading above the line, and the column that has the rate. The value lists the dots,
each as the table of a domain and the model's row in this table.
"""

_PAPERS = ("paper", "published")


def list_models_and_protocols(tables: Iterable[Ranking]) -> list[tuple[str, Protocol]]:
    """Return pairs of a model and a protocol (scoring rules) that have runs, in the order of the tables."""
    models = ((row.model, table.protocol) for table in tables for row in table.rows if row.source == "run")
    return list(dict.fromkeys(models))


def draw_model_summary(tables: Sequence[Ranking], model: str, protocol: Protocol) -> Figure | None:
    """Draw the page of a model; return None if the model has no numbers.

    Rates are dots with 95 % intervals, with their values as text. Each domain has a mark and a colour. Grey
    ticks are the paper's models, if the tables have them.

    Args:
        tables: the tables of a report, for all protocols and domains.
        model: the model.
        protocol: the scoring rules of the drawn results.
    """
    shown = [
        (table, row)
        for table in tables
        if table.protocol is protocol
        for row in [row for row in table.rows if row.source == "run" and row.model == model][:1]
    ]
    domains: dict[str, str] = {}
    for table, row in shown:
        answered = "" if row.coverage is None else f", {row.coverage} answered"
        domains.setdefault(table.domain, f"{get_title(table.domain)}{answered}")
    all_panels = {
        title: _group_ranked_rows_by_panel_metric(shown, names, groups) for title, names, groups in _PANELS
    }
    panels = {title: lines for title, lines in all_panels.items() if lines}
    if not panels:
        return None
    heights = [_HEAD + _LINE * _compute_panel_height_in_lines(lines) for lines in panels.values()]
    figure = make_figure(PAGE, sum(heights) + _FOOT)
    figure.suptitle(f"{clip_label(model)}, protocol {protocol.value}", x=0.01, ha="left", fontsize=12)
    grid = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    for axes, (title, lines) in zip(grid, panels.items(), strict=True):
        axes.set_title(title, fontsize=9.5)
        _draw_summary_panel(axes, lines, list(domains))
    _draw_legend(
        figure, list(domains.values()), _make_legend_text_for_paper_models([table for table, _ in shown])
    )
    return figure


def _group_ranked_rows_by_panel_metric(
    rows: Sequence[tuple[Ranking, RankedModel]], table_names: Sequence[str], column_groups: Sequence[str]
) -> _RankedRowsByPanelMetric:
    """Return the lines of one panel of the page: a line for each rate in the tables with the given names."""
    return group_pairs(
        ((format_ability_title(column.ability) if column.ability else column.group, column), (table, row))
        for name in table_names
        for table, row in rows
        if table.name == name
        for column in table.columns
        if not column_groups or column.group in column_groups
    )


def _compute_panel_height_in_lines(lines: _RankedRowsByPanelMetric) -> int:
    """Return the height of a panel in lines, including one line for the heading of each group."""
    return len(lines) + len({heading for heading, _ in lines})


def _make_legend_text_for_paper_models(tables: Sequence[Ranking]) -> str | None:
    """Return the legend's text on the grey ticks of the paper's models, or None if no ticks are drawn."""
    rows = [row for table in tables for row in table.rows]
    printed = {row.model for row in rows if row.source == "paper"}
    scored = {row.model for row in rows if row.source == "published"}
    if printed:
        return f"the paper's models, as it prints them ({len(printed)})"
    return f"published answers of the paper's models ({len(scored)})" if scored else None


def _draw_summary_panel(axes: Axes, lines: _RankedRowsByPanelMetric, domains: Sequence[str]) -> None:
    axes.set_xlim(-1, 101)
    axes.set_ylim(_compute_panel_height_in_lines(lines) - 0.4, -0.6)
    axes.grid(axis="x", color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=7)
    heights, labels, line = [], [], 0
    for heading, group in groupby(lines, key=lambda pair: pair[0]):
        style = {"ha": "right", "va": "center", "fontsize": 7.5, "weight": "bold"}
        axes.text(-0.01, line, heading, style, transform=axes.get_yaxis_transform())
        for key in group:
            line += 1
            heights.append(line)
            labels.append(clip_label(key[1].label))
            for table, row in lines[key]:
                _draw_score_mark(axes, line, (table, row, key[1]), domains)
        line += 1
    axes.set_yticks(heights, labels=labels, fontsize=7.5)


def _draw_score_mark(
    axes: Axes, line: int, mark: tuple[Ranking, RankedModel, MetricColumn], domains: Sequence[str]
) -> None:
    table, row, column = mark
    score, number = row.scores[column], domains.index(table.domain)
    if score.value is None:
        return
    at, color = line + _APART * (number - (len(domains) - 1) / 2), _choose_color_of_domain(number)
    others = (other.scores[column].value for other in table.rows if other.source in _PAPERS)
    for percent in (percent for percent in others if percent is not None):
        axes.plot(percent, at, "|", color=MUTED, markersize=4, markeredgewidth=0.7, alpha=0.7)
    if score.low is not None and score.high is not None:
        axes.hlines(at, score.low, score.high, color=color, linewidth=1.2)
    axes.plot(
        score.value, at, _choose_marker_of_domain(number), color=color, markersize=4, zorder=3, clip_on=False
    )
    beside, text = axes.get_yaxis_transform(), f"{score.value:.1f}"
    axes.text(1.01 + 0.055 * number, line, text, transform=beside, fontsize=7, va="center", color=color)


def _draw_legend(figure: Figure, domains: Sequence[str], tick_label: str | None) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            marker=_choose_marker_of_domain(number),
            color=_choose_color_of_domain(number),
            markersize=4,
            label=domain,
        )
        for number, domain in enumerate(domains)
    ]
    if tick_label is not None:
        handles.append(Line2D([], [], marker="|", linestyle="", color=MUTED, markersize=6, label=tick_label))
    figure.legend(
        handles=handles,
        title="Bars are 95 % intervals with the tasks' names as units.",
        title_fontsize=7,
        loc="outside lower center",
        ncols=len(handles),
        frameon=False,
        fontsize=7,
    )


def _choose_marker_of_domain(domain_number: int) -> str:
    return _MARKS[domain_number % len(_MARKS)]


def _choose_color_of_domain(domain_number: int) -> str:
    return MODEL_COLORS[domain_number % len(MODEL_COLORS)]
