"""A model on one page: its main results, the goals that it reaches and what goes wrong, by domain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from eai.abilities.declaration import GRAMMAR, RUNTIME, MetricColumn
from eai.abilities.protocol import Ability, Protocol
from eai.benchmark.registry import title_of
from eai.report.ranking import Cell, Ranking, Row
from eai.report.table_specs import ability_title
from eai.results.plots import LINES, MUTED, PAGE, RULE, clipped, sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKS = "osD^v"
_LINE = 0.19
"""The height of a line of a panel, in inches."""

_HEAD = 0.5
"""The height of a panel besides its lines, in inches."""

_FOOT = 0.75
"""The height of the title and the legend, in inches."""

_APART = 0.3
"""How far the domains' marks stand from each other, in lines."""


class _Entry(NamedTuple):
    """A line of a panel: what is measured, in each domain that has it."""

    group: str
    label: str
    cells: dict[str, Cell]
    others: dict[str, list[float]]


_PAPERS = ("paper", "published")


def _lines(entries: Sequence[_Entry]) -> int:
    """How many lines a panel has, a heading for each group included."""
    return len(entries) + len({entry.group for entry in entries})


def models_of(tables: Iterable[Ranking]) -> list[tuple[str, Protocol]]:
    """The models that runs are of, each with its protocols, in the order of the tables."""
    found = ((row.model, table.protocol) for table in tables for row in table.rows if row.source == "run")
    return list(dict.fromkeys(found))


def draw(tables: Sequence[Ranking], model: str, protocol: Protocol) -> Figure | None:
    """The page of a model; None if it has no numbers.

    Rates are dots with their 95 % intervals, a mark and a colour a domain, and their numbers beside them. The
    paper's models are grey ticks, where the tables have them.

    Args:
        tables: those of a report, of all protocols and domains.
        model: the model.
        protocol: the protocol.
    """
    shown = [
        (table, row)
        for table in tables
        if table.protocol is protocol
        for row in [each for each in table.rows if each.source == "run" and each.model == model][:1]
    ]
    domains: dict[str, str] = {}
    for table, row in shown:
        answered = "" if row.coverage is None else f", {row.coverage} answered"
        domains.setdefault(table.domain, f"{title_of(table.domain)}{answered}")
    panels = {title: entries for title, entries in _panels(shown).items() if entries}
    if not panels:
        return None
    heights = [_HEAD + _LINE * _lines(entries) for entries in panels.values()]
    figure = sheet(PAGE, sum(heights) + _FOOT)
    figure.suptitle(f"{clipped(model)}, protocol {protocol.value}", x=0.01, ha="left", fontsize=12)
    grid = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    for axes, (title, entries) in zip(grid, panels.items(), strict=True):
        axes.set_title(title, fontsize=9.5)
        _draw_panel(axes, entries, list(domains))
    _draw_legend(figure, list(domains.values()), _others([table for table, _ in shown]))
    return figure


def _panels(shown: Sequence[tuple[Ranking, Row]]) -> dict[str, list[_Entry]]:
    """The lines of each panel by its title."""
    plans = [
        f"{each.value}_trajectory" for each in (Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION)
    ]
    faults = [entry for name in plans for entry in _entries(shown, name, (GRAMMAR, RUNTIME))]
    return {
        "Main results, percent": _entries(shown, "overview"),
        "Goals that its plans reach, percent": _entries(shown, "goal_satisfaction"),
        "What goes wrong in its plans, percent of answers": faults,
    }


def _entries(
    shown: Sequence[tuple[Ranking, Row]], name: str, groups: Sequence[str] | None = None
) -> list[_Entry]:
    """The columns of the tables of one name as lines, below the abilities that they are of."""
    entries: dict[MetricColumn, _Entry] = {}
    for table, row in shown:
        for place, column in enumerate(table.columns):
            if table.name == name and (groups is None or column.group in groups):
                heading = ability_title(column.ability) if column.ability else column.group
                entry = entries.setdefault(column, _Entry(heading, column.label, {}, {}))
                entry.cells[table.domain] = row.cells[place]
                others = (each.cells[place].percent for each in table.rows if each.source in _PAPERS)
                entry.others[table.domain] = [percent for percent in others if percent is not None]
    return list(entries.values())


def _others(tables: Sequence[Ranking]) -> str | None:
    """The meaning of the ticks; None if there are none."""
    rows = [row for table in tables for row in table.rows]
    printed = {row.model for row in rows if row.source == "paper"}
    scored = {row.model for row in rows if row.source == "published"}
    if printed:
        return f"the paper's models, as it prints them ({len(printed)})"
    return f"published answers of the paper's models ({len(scored)})" if scored else None


def _draw_panel(axes: Axes, entries: Sequence[_Entry], domains: Sequence[str]) -> None:
    axes.set_xlim(-1, 101)
    axes.set_ylim(_lines(entries) - 0.4, -0.6)
    axes.grid(axis="x", color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    axes.tick_params(axis="x", labelsize=7)
    places, labels, line = [], [], 0
    for group, of_group in groupby(entries, key=lambda entry: entry.group):
        style = {"ha": "right", "va": "center", "fontsize": 7.5, "weight": "bold"}
        axes.text(-0.01, line, group, style, transform=axes.get_yaxis_transform())
        for entry in of_group:
            line += 1
            places.append(line)
            labels.append(clipped(entry.label))
            _draw_entry(axes, line, entry, domains)
        line += 1
    axes.set_yticks(places, labels=labels, fontsize=7.5)


def _draw_entry(axes: Axes, line: int, entry: _Entry, domains: Sequence[str]) -> None:
    beside = axes.get_yaxis_transform()
    for number, domain in enumerate(domains):
        cell = entry.cells.get(domain)
        if cell is None or cell.percent is None:
            continue
        at = line + _APART * (number - (len(domains) - 1) / 2)
        color = _color(number)
        for other in entry.others[domain]:
            axes.plot(other, at, "|", color=MUTED, markersize=4, markeredgewidth=0.7, alpha=0.7)
        if cell.interval is not None:
            axes.hlines(at, *cell.interval, color=color, linewidth=1.2)
        axes.plot(cell.percent, at, _mark(number), color=color, markersize=4, zorder=3, clip_on=False)
        x = 1.01 + 0.055 * number
        axes.text(x, line, f"{cell.percent:.1f}", transform=beside, fontsize=7, va="center", color=color)


def _draw_legend(figure: Figure, domains: Sequence[str], others: str | None) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], marker=_mark(number), color=_color(number), markersize=4, label=domain)
        for number, domain in enumerate(domains)
    ]
    if others is not None:
        handles.append(Line2D([], [], marker="|", linestyle="", color=MUTED, markersize=6, label=others))
    figure.legend(
        handles=handles,
        title="Bars are 95 % intervals with the tasks' names as units.",
        title_fontsize=7,
        loc="outside lower center",
        ncols=len(handles),
        frameon=False,
        fontsize=7,
    )


def _mark(number: int) -> str:
    return _MARKS[number % len(_MARKS)]


def _color(number: int) -> str:
    return LINES[number % len(LINES)]
