"""Plots of a data set: how many tasks have so many steps and goals; which actions plans take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeGuard

from eai.results.data_set import Distribution
from eai.results.plots import ACCENT, INK, RULE, clipped, sheet, styled, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANEL = (3.5, 1.9)
"""A column of a page wide, in inches."""
_COLUMNS = 2
_MOST_NAMES = 25
"""So many of the most frequent actions, objects and pairs are shown; files have all."""
_ROW = 0.16
_BINS = 24
"""At most so many bars of numbers."""


def save(found: Sequence[Distribution], title: str, path: Path) -> tuple[Path, ...]:
    """Write the numbers to ``path-numbers`` and the names to ``path-names``, each as SVG and PNG.

    Raises:
        EaiError: matplotlib is not installed.
    """
    numbers = [each for each in found if _of_numbers(each.counts)]
    names = [each for each in found if not _of_numbers(each.counts)]
    written: list[Path] = []
    with styled():
        for kind, chosen, height in (("numbers", numbers, _PANEL[1]), ("names", names, _height(names))):
            if chosen:
                written += write(_draw(chosen, title, height), path.with_name(f"{path.name}-{kind}"))
    return tuple(written)


def _draw(found: Sequence[Distribution], title: str, height: float) -> Figure:
    rows = -(-len(found) // _COLUMNS)
    figure = sheet(_PANEL[0] * _COLUMNS, height * rows + 0.3)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).flatten()
    for panel, each in zip(panels, found, strict=False):
        panel.set_title(each.title)
        if _of_numbers(each.counts):
            _bars(panel, binned(each.counts, decades=each.decades), each.of)
        else:
            _names(panel, {str(name): count for name, count in each.counts.items()}, each.of)
    for panel in panels[len(found) :]:
        panel.set_visible(False)
    return figure


def binned(counts: Mapping[int, int], *, decades: bool) -> dict[str, int]:
    """Counts by bin, with a bin's bounds as its label; bins without a case in between are there, too."""
    if decades:
        powers = range(len(str(max(counts))))
        return {
            _decade(power): sum(n for value, n in counts.items() if len(str(value)) == power + 1)
            for power in powers
        }
    width = next(width for width in (1, 2, 5, 10, 20, 50, 100, 10**9) if max(counts) // width < _BINS)
    bins = range(min(counts) // width, max(counts) // width + 1)
    return {
        _label(number * width, width): sum(n for value, n in counts.items() if value // width == number)
        for number in bins
    }


def _decade(power: int) -> str:
    return f"{10**power:,}+" if power else "1-9"


def _label(low: int, width: int) -> str:
    return str(low) if width == 1 else f"{low}-{low + width - 1}"


def _bars(panel: Axes, bins: Mapping[str, int], of: str) -> None:
    panel.bar(range(len(bins)), list(bins.values()), width=0.86, color=ACCENT)
    every = -(-len(bins) // 8)
    panel.set_xticks(range(0, len(bins), every), labels=list(bins)[::every], fontsize=7)
    panel.set_ylabel(of)
    panel.set_axisbelow(True)
    panel.yaxis.grid(visible=True, color=RULE, linewidth=0.6)
    if len(bins) <= 8:
        for place, number in enumerate(bins.values()):
            panel.annotate(str(number), (place, number), ha="center", va="bottom", fontsize=6.5, color=INK)


def _names(panel: Axes, counts: Mapping[str, int], of: str) -> None:
    shown = dict(list(counts.items())[:_MOST_NAMES])
    panel.barh(range(len(shown)), list(shown.values()), height=0.8, color=ACCENT)
    panel.set_yticks(range(len(shown)), labels=[clipped(name) for name in shown], fontsize=6.2)
    panel.set_ylim(max(len(shown), 1) - 0.4, -0.6)
    panel.tick_params(axis="y", length=0)
    left = len(counts) - len(shown)
    panel.set_xlabel(of if not left else f"{of} (the {len(shown)} most frequent of {len(counts)})")


def _height(found: Sequence[Distribution]) -> float:
    return _ROW * max((min(len(each.counts), _MOST_NAMES) for each in found), default=0) + 0.7


def _of_numbers(counts: Mapping[int, int] | Mapping[str, int]) -> TypeGuard[Mapping[int, int]]:
    return all(isinstance(value, int) for value in counts)
