"""Plots for papers, as SVG and PNG. Needs matplotlib, which is imported when there is something to draw."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain, groupby
from pathlib import Path
from typing import TYPE_CHECKING

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import place_of
from eai.abilities.responses import file_name
from eai.report import plot_difficulty, plot_summary
from eai.report.document import Plot
from eai.report.plot_runs import draw_actions, draw_flow, draw_outcomes, draw_predicates, draw_radar
from eai.report.ranking import Ranking
from eai.report.run_summary import RunSummary
from eai.report.table_specs import ability_title, domain_title
from eai.results.markdown import escaped
from eai.results.plots import entitle, styled, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DIFFICULTY = (
    "Success by number of goals and by length of the data set's own plan (below, how many tasks; marks of "
    "fewer than five are hollow; bars of up to three models are 95 % intervals)"
)


def draw_plots(runs: Sequence[RunSummary], folder: Path, pages: Sequence[Ranking] = ()) -> list[Plot]:
    """Draw everything that the runs have numbers for; returns what was drawn, in order.

    Args:
        runs: the runs, sorted by the order of their keys.
        folder: where the plots go.
        pages: the tables from which each model gets a page that sums it up; none if empty.

    Raises:
        EaiError: matplotlib is not installed.
    """
    drawn = []
    with styled():
        folder.mkdir(parents=True, exist_ok=True)
        for plot, figure in chain(_pages(pages), _figures(runs)):
            _save(figure, folder / plot.name)
            drawn.append(plot)
    return drawn


def _pages(tables: Sequence[Ranking]) -> Iterator[tuple[Plot, Figure]]:
    for model, protocol in plot_summary.models_of(tables):
        name = file_name(f"summary-{model}-{protocol.value}")
        caption = f"{escaped(model)} on one page, protocol {protocol.value}"
        yield from _drawn(name, caption, plot_summary.draw(tables, model, protocol))


def _figures(runs: Sequence[RunSummary]) -> Iterator[tuple[Plot, Figure]]:
    ordered = sorted(runs, key=lambda item: item.key.order)
    for (protocol, domain), items in groupby(ordered, lambda item: (item.key.protocol, item.key.domain)):
        group = list(items)
        place = f"{domain_title(domain)}, protocol {protocol.value}"
        name = file_name(f"{domain}-{protocol.value}")
        whole: Sequence[tuple[str, str, Callable[[Sequence[RunSummary]], Figure | None]]] = (
            ("radar", "Main results by model", draw_radar),
            ("outcomes", "What answers came to", draw_outcomes),
        )
        for kind, caption, draw in whole:
            yield from _drawn(f"{kind}-{name}", f"{caption}: {place}", draw(group), place)
        for ability in sorted({item.key.ability for item in group}, key=place_of):
            of_ability = [item for item in group if item.key.ability is ability]
            what = f"{ability_title(ability).lower()}, {place}"
            title = f"{domain_title(domain)} {ability_title(ability).lower()}, {protocol.value}"
            slug = f"{ability.value}-{name}"
            if declaration_of(ability).has_plans:
                caption = f"From answer to outcome: {what}"
                yield from _drawn(f"flow-{slug}", caption, draw_flow(of_ability), title)
            caption = f"{_DIFFICULTY}: {what}"
            yield from _drawn(f"difficulty-{slug}", caption, plot_difficulty.draw(of_ability), title)
            for kind, draw_by in (
                ("action", draw_actions),
                ("predicate", draw_predicates),
            ):
                caption = f"By {kind} (of fewer than five cases in brackets): {what}"
                yield from _drawn(f"{kind}s-{slug}", caption, draw_by(of_ability), title)


def _drawn(name: str, caption: str, figure: Figure | None, title: str = "") -> Iterator[tuple[Plot, Figure]]:
    if figure is not None:
        if title:
            entitle(figure, title)
        yield Plot(name, caption), figure


def _save(figure: Figure, path: Path) -> None:
    """Write a figure in all formats.

    Nothing is clipped: nothing needs it, and the name of a clipping area is made from all digits of numbers
    that the solver of the layout does not always give alike.
    """
    for artist in figure.findobj():
        artist.set_clip_on(False)
    write(figure, path)
