"""Distributions of a data set: how many tasks have so many steps and goals; which actions plans take."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.features import Features
from eai.results.data_set import profile_tasks
from eai.results.plots import ACCENT, INK, RULE, clip_label, make_figure, use_plot_style, write
from eai.tasks.source import Source
from eai.tasks.task import Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class _Distribution:
    """How often each value occurs.

    Attributes:
        name: its name in files.
        title: what is counted, in words.
        of: what `counts` counts: ``tasks``, of which values are numbers; or ``steps``, or ``mentions`` of
            objects in steps, of which they are names.
        counts: value -> how often, by value if values are numbers, else the most frequent first.
        decades: whether the numbers are so unlike that only their decade (1 to 9, 10 to 99, ...) tells.
    """

    name: str
    title: str
    of: str
    counts: Mapping[Any, int]
    decades: bool = False


def distributions(benchmark: Benchmark, source: Source) -> tuple[_Distribution, ...]:
    """The distributions of a benchmark, over its tasks with goals; those without any case are left out.

    Raises:
        DataError: the data cannot be had.
    """
    asked = [each for each in profile_tasks(benchmark, source) if each.features.goals]
    found = (*_of_features([each.features for each in asked]), *_of_steps([each.task for each in asked]))
    return tuple(each for each in found if each.counts)


def _of_features(features: Sequence[Features]) -> Iterator[_Distribution]:
    for name, title in (
        ("annotated_steps", "Steps of the annotated plan"),
        ("goals", "Goals (conjuncts)"),
        ("ground_goals", "Ground goals"),
        ("goal_options", "Ways to meet the goals"),
        ("objects", "Objects the task is about"),
    ):
        values = [value for each in features if (value := getattr(each, name)) is not None]
        counts = dict(sorted(Counter(values).items()))
        yield _Distribution(name, title, "tasks", counts, decades=name == "goal_options")


def _of_steps(tasks: Sequence[Task]) -> Iterator[_Distribution]:
    """The actions of annotated plans' steps, and with what category of object."""
    steps = [(step, task.scene.objects) for task in tasks for step in task.script]
    pairs = [(step.operator, objects[i].category) for step, objects in steps for i in step.arguments]
    actions = _ranked(step.operator for step, _ in steps)
    yield _Distribution("actions", "Actions of annotated plans", "steps", actions)
    categories = _ranked(category for _, category in pairs)
    yield _Distribution("categories", "Objects of those steps, by category", "mentions", categories)
    yield _Distribution("pairs", "Actions with objects", "mentions", _ranked(map(" ".join, pairs)))


def _ranked(values: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(values).items(), key=lambda item: (-item[1], item[0])))


_PANEL = (3.5, 1.9)
"""A column of a page wide, in inches."""
_COLUMNS = 2
_MOST_NAMES = 25
"""So many of the most frequent actions, objects and pairs are shown; files have all."""
_ROW = 0.16
_BINS = 24
"""At most so many bars of numbers."""


def save(found: Sequence[_Distribution], title: str, path: Path) -> tuple[Path, ...]:
    """Write the numbers to ``path-numbers`` and the names to ``path-names``, each as SVG and PNG.

    Raises:
        EaiError: matplotlib is not installed.
    """
    numbers = [each for each in found if each.of == "tasks"]
    names = [each for each in found if each.of != "tasks"]
    longest = max((min(len(each.counts), _MOST_NAMES) for each in names), default=0)
    written: list[Path] = []
    with use_plot_style():
        for kind, chosen, height in (("numbers", numbers, _PANEL[1]), ("names", names, _ROW * longest + 0.7)):
            if chosen:
                written += write(_draw(chosen, title, height), path.with_name(f"{path.name}-{kind}"))
    return tuple(written)


def _draw(found: Sequence[_Distribution], title: str, height: float) -> Figure:
    rows = -(-len(found) // _COLUMNS)
    figure = make_figure(_PANEL[0] * _COLUMNS, height * rows + 0.3)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).flatten()
    for panel, each in zip(panels, found, strict=False):
        panel.set_title(each.title)
        (_bars if each.of == "tasks" else _names)(panel, each)
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


def _bars(panel: Axes, found: _Distribution) -> None:
    bins = binned(found.counts, decades=found.decades)
    panel.bar(range(len(bins)), list(bins.values()), width=0.86, color=ACCENT)
    every = -(-len(bins) // 8)
    panel.set_xticks(range(0, len(bins), every), labels=list(bins)[::every], fontsize=7)
    panel.set_ylabel(found.of)
    panel.set_axisbelow(True)
    panel.yaxis.grid(visible=True, color=RULE, linewidth=0.6)
    if len(bins) <= 8:
        for place, number in enumerate(bins.values()):
            panel.annotate(str(number), (place, number), ha="center", va="bottom", fontsize=6.5, color=INK)


def _names(panel: Axes, found: _Distribution) -> None:
    shown = dict(list(found.counts.items())[:_MOST_NAMES])
    panel.barh(range(len(shown)), list(shown.values()), height=0.8, color=ACCENT)
    panel.set_yticks(range(len(shown)), labels=[clip_label(name) for name in shown], fontsize=6.2)
    panel.set_ylim(max(len(shown), 1) - 0.4, -0.6)
    panel.tick_params(axis="y", length=0)
    some = (
        "" if len(shown) == len(found.counts) else f" (the {len(shown)} most frequent of {len(found.counts)})"
    )
    panel.set_xlabel(f"{found.of}{some}")
