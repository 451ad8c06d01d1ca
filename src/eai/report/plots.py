"""Plots for papers. Needs matplotlib, which is imported when there is something to draw.

Drawn here: success against the number of goals of tasks, and against the length of the data set's own plan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from eai.abilities.protocol import place_of
from eai.abilities.responses import file_name
from eai.benchmark.registry import title_of
from eai.data.files import write_whole
from eai.data.grouping import grouped
from eai.report import plot_summary
from eai.report.plot_runs import draw_actions, draw_flow, draw_outcomes, draw_predicates
from eai.report.ranking import Ranking
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title
from eai.results.certainty import Case, Cases
from eai.results.markdown import escaped
from eai.results.plots import FEW, LINES, RULE, clipped, draw_line, entitle, sheet, styled, write
from eai.results.table import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DIFFICULTY = (
    "Success by number of goals and by length of the data set's own plan (below, how many tasks; marks of "
    "fewer than five are hollow; bars of up to three models are 95 % intervals)"
)


BIN = 10
"""How many lengths stand together: bins are 0-9, 10-19 and so on, as in the paper's figure."""

_MANY = 10
"""So many goals, and more, stand together."""

_MOST_WITH_INTERVALS = 3
"""More models than this in one panel leave no room for intervals."""
_PANEL = (3.5, 2.5)
"""A column of a page, in inches, so that letters have the size that they say."""
_LEGEND_ROW = 0.17
_LEGEND_COLUMNS = {1: 1, 2: 3}
"""Number of panels -> names of models beside each other."""
_MARKS = "os^Dv<>ph"
_STYLES = ("-", "--", ":", "-.")
_APART = 0.09
"""How far models stand beside each other where intervals are drawn."""

Bins = Mapping[int, Cases]
"""Bin -> successes of one model; a bin without tasks is not there."""


class Plot(NamedTuple):
    """A plot by the name of its files, without ending, what it shows, and what draws it if it has numbers."""

    name: str
    caption: str
    draw: Callable[[], Figure | None]


def plan_plots(runs: Sequence[RunSummary], pages: Sequence[Ranking] = ()) -> list[Plot]:
    """All plots that runs may have numbers for, in order.

    Args:
        runs: the runs, sorted by the order of their keys.
        pages: the tables from which each model gets a page that sums it up; none if empty.
    """
    return [*_pages(pages), *_figures(runs)]


def draw_plots(planned: Iterable[Plot], folder: Path, formats: Sequence[str]) -> Iterator[Plot | None]:
    """Draw plots one by one; each is given when its files are there, or None if it has no numbers.

    Nothing is clipped: nothing needs it, and the name of a clipping area is made from all digits of numbers
    that the solver of the layout does not always give alike.

    Args:
        planned: the plots.
        folder: where they go.
        formats: those of `eai.results.plots.FORMATS` in which each is written.

    Raises:
        EaiError: matplotlib is not installed.
    """
    with styled():
        folder.mkdir(parents=True, exist_ok=True)
        for plot in planned:
            figure = plot.draw()
            if figure is not None:
                write(figure, folder / plot.name, formats, clips=False)
            yield None if figure is None else plot


def add_plots(folder: Path, plots: Sequence[Plot], kind: str) -> None:
    """Show plots, drawn in files of a format, at the end of ``report.md``."""
    page = folder / "report.md"
    shown = (f"{plot.caption}\n\n![{plot.caption}](plots/{plot.name}.{kind})\n" for plot in plots)
    write_whole({page: "\n".join((f"{page.read_text(encoding='utf-8')}\n## Plots\n", *shown))})


def _pages(tables: Sequence[Ranking]) -> Iterator[Plot]:
    for model, protocol in plot_summary.models_of(tables):
        name = file_name(f"summary-{model}-{protocol.value}")
        caption = f"{escaped(model)} on one page, protocol {protocol.value}"
        yield Plot(name, caption, partial(plot_summary.draw, tables, model, protocol))


def _figures(runs: Sequence[RunSummary]) -> Iterator[Plot]:
    ordered = sorted(runs, key=lambda item: item.key.order)
    for (protocol, domain), items in groupby(ordered, lambda item: (item.key.protocol, item.key.domain)):
        group = list(items)
        place = f"{title_of(domain)}, protocol {protocol.value}"
        name = file_name(f"{domain}-{protocol.value}")
        drawn = partial(_entitled, place, draw_outcomes, group)
        yield Plot(f"outcomes-{name}", f"Outcomes of answers: {place}", drawn)
        for ability in sorted({item.key.ability for item in group}, key=place_of):
            of_ability = [item for item in group if item.key.ability is ability]
            title = f"{title_of(domain)} {ability_title(ability).lower()}, {protocol.value}"
            for kind, caption, draw in _OF_ABILITY:
                caption = f"{caption}: {ability_title(ability).lower()}, {place}"
                drawn = partial(_entitled, title, draw, of_ability)
                yield Plot(f"{kind}-{ability.value}-{name}", caption, drawn)


def _entitled(title: str, draw: _Draw, runs: Sequence[RunSummary]) -> Figure | None:
    """A figure below its title."""
    figure = draw(runs)
    if figure is not None:
        entitle(figure, title)
    return figure


def draw_difficulty(runs: Sequence[RunSummary]) -> Figure | None:
    """Success by number of goals and by length of the annotated plan, a line a model.

    None if neither is known, or all tasks are alike.
    """
    panels = [
        (
            "goals of the task",
            lambda place: str(place) if place < _MANY else f"{_MANY}+",
            [_binned(item.breakdown.by_goals, lambda goals: min(goals, _MANY)) for item in runs],
        ),
        (
            "steps of the annotated plan",
            lambda place: f"{place * BIN}–{place * BIN + BIN - 1}",
            [_binned(item.breakdown.by_length, lambda length: length // BIN) for item in runs],
        ),
    ]
    panels = [panel for panel in panels if any(len(bins) > 1 for bins in panel[2])]
    if not panels:
        return None
    columns = min(_LEGEND_COLUMNS[len(panels)], len(runs))
    legend = _LEGEND_ROW * -(-len(runs) // columns)
    figure = sheet(_PANEL[0] * len(panels), _PANEL[1] + legend)
    grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    for panel, (label, name_of_bin, series) in zip(grid, panels, strict=True):
        panel.set_xlabel(label)
        _draw_panel(panel, name_of_bin, series, [clipped(item.key.name) for item in runs])
    grid[0].set_ylabel("success in percent")
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=7)
    return figure


def _binned(table: Mapping[int, Cases], bin_of: Callable[[int], int]) -> dict[int, list[Case]]:
    return grouped((bin_of(number), case) for number, cases in table.items() for case in cases)


def _draw_panel(
    panel: Axes, name_of_bin: Callable[[int], str], series: Sequence[Bins], models: Sequence[str]
) -> None:
    panel.set_ylim(-3, 103)
    panel.grid(axis="y", color=RULE, linewidth=0.7)
    places = sorted({place for bins in series for place in bins})
    tasks = [max(len(bins.get(place, ())) for bins in series) for place in places]
    labels = [f"{name_of_bin(place)}\n{count}" for place, count in zip(places, tasks, strict=True)]
    panel.set_xticks(places, labels=labels, fontsize=7)
    panel.text(-0.03, -0.115, "tasks", transform=panel.transAxes, fontsize=7, ha="right", va="top")
    for number, (bins, model) in enumerate(zip(series, models, strict=True)):
        color, mark = LINES[number % len(LINES)], _MARKS[number % len(_MARKS)]
        style = _STYLES[number // len(LINES) % len(_STYLES)]
        intervals = len(series) <= _MOST_WITH_INTERVALS
        shift = _APART * (number - (len(series) - 1) / 2) if intervals else 0.0
        known = range(min(bins, default=0), max(bins, default=-1) + 1)
        cells = [Estimate.of(bins.get(place, ())) for place in known]
        hollow = [place + shift for place in bins if len(bins[place]) < FEW]
        at, look = [place + shift for place in known], mark + style
        draw_line(panel, at, cells, color, look, hollow=hollow, intervals=intervals, label=model)


_Draw: TypeAlias = "Callable[[Sequence[RunSummary]], Figure | None]"

_OF_ABILITY: Sequence[tuple[str, str, _Draw]] = (
    ("flow", "From answer to outcome", draw_flow),
    ("difficulty", _DIFFICULTY, draw_difficulty),
    ("actions", "By action (of fewer than five cases in brackets)", draw_actions),
    ("predicates", "By predicate (of fewer than five cases in brackets)", draw_predicates),
)
"""The plots of an ability: name, caption, and what draws it, where there is something to draw."""
