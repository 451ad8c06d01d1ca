"""Count and draw the steps and goals of a data set's tasks, and the actions of its annotated plans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.features import TaskStatistics
from eai.results.data_set import profile_tasks
from eai.results.plots import ACCENT, INK, RULE, clip_label, make_figure, use_plot_style, write_figure
from eai.tasks.source import Source
from eai.tasks.task import Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class _ValueDistribution:
    """How many times each value of a property occurs in a data set.

    Attributes:
        name: name of the property in file names.
        title: name of the property for readers.
        unit: the counted items: ``tasks`` if values are numbers, ``steps`` if they are names of actions.
            ``mentions`` of objects in steps are counted by the object's category, or by action and category.
        counts: value -> number of items. Numeric values are in order; names start with the most frequent.
        decades: whether values are grouped by decade (1 to 9, 10 to 99, ...), because they differ so much.
    """

    name: str
    title: str
    unit: str
    counts: Mapping[Any, int]
    decades: bool = False


def make_task_property_distributions(benchmark: Benchmark, source: Source) -> tuple[_ValueDistribution, ...]:
    """Return the distributions of steps, goals and actions in a benchmark's tasks with goals.

    Empty distributions are left out.

    Raises:
        DataError: the data is not available.
    """
    profiles = [profile for profile in profile_tasks(benchmark, source) if profile.features.goals]
    counted = (
        *_make_feature_distributions([profile.features for profile in profiles]),
        *_make_plan_step_distributions([profile.task for profile in profiles]),
    )
    return tuple(distribution for distribution in counted if distribution.counts)


def _make_feature_distributions(features: Sequence[TaskStatistics]) -> Iterator[_ValueDistribution]:
    for name, title in (
        ("annotated_steps", "Steps of the annotated plan"),
        ("goals", "Goals (conjuncts)"),
        ("ground_goals", "Ground goals"),
        ("goal_options", "Ways to meet the goals"),
        ("objects", "Objects the task is about"),
    ):
        values = [value for task in features if (value := getattr(task, name)) is not None]
        counts = dict(sorted(Counter(values).items()))
        yield _ValueDistribution(name, title, "tasks", counts, decades=name == "goal_options")


def _make_plan_step_distributions(tasks: Sequence[Task]) -> Iterator[_ValueDistribution]:
    """Yield the distributions of actions, of object categories, and of pairs of both, in annotated plans."""
    steps = [(step, task.scene.objects) for task in tasks for step in task.script]
    pairs = [(step.operator, objects[i].category) for step, objects in steps for i in step.arguments]
    actions = _count_values(step.operator for step, _ in steps)
    yield _ValueDistribution("actions", "Actions of annotated plans", "steps", actions)
    categories = _count_values(category for _, category in pairs)
    yield _ValueDistribution("categories", "Objects of those steps, by category", "mentions", categories)
    yield _ValueDistribution("pairs", "Actions with objects", "mentions", _count_values(map(" ".join, pairs)))


def _count_values(values: Iterable[str]) -> dict[str, int]:
    return dict(sorted(Counter(values).items(), key=lambda item: (-item[1], item[0])))


_PANEL = (3.5, 1.9)
"""Width (one column of a page) and height of a panel, in inches."""
_COLUMNS = 2
_MAX_NAMES = 25
"""Maximum number of names in a panel, such as actions or categories, most frequent first."""
_ROW = 0.16
_MAX_BINS = 24
"""Maximum number of bars in a panel whose values are numbers."""


def write_distribution_plots(
    distributions: Sequence[_ValueDistribution], title: str, path: Path
) -> tuple[Path, ...]:
    """Draw distributions of numbers and of names, as SVG and PNG.

    The names of the files are ``path`` with ``-numbers`` or ``-names`` at its end.

    Raises:
        EaiError: matplotlib is not installed.
    """
    numbers = [item for item in distributions if item.unit == "tasks"]
    names = [item for item in distributions if item.unit != "tasks"]
    longest = max((min(len(item.counts), _MAX_NAMES) for item in names), default=0)
    written: list[Path] = []
    with use_plot_style():
        for kind, chosen, height in (("numbers", numbers, _PANEL[1]), ("names", names, _ROW * longest + 0.7)):
            if chosen:
                written += write_figure(
                    _draw_distributions(chosen, title, height), path.with_name(f"{path.name}-{kind}")
                )
    return tuple(written)


def _draw_distributions(distributions: Sequence[_ValueDistribution], title: str, height: float) -> Figure:
    rows = -(-len(distributions) // _COLUMNS)
    figure = make_figure(_PANEL[0] * _COLUMNS, height * rows + 0.3)
    figure.suptitle(title, x=0.01, ha="left", fontsize=9.5)
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).flatten()
    for panel, item in zip(panels, distributions, strict=False):
        panel.set_title(item.title)
        (_draw_bars if item.unit == "tasks" else _draw_bar_per_named_value)(panel, item)
    for panel in panels[len(distributions) :]:
        panel.set_visible(False)
    return figure


def group_counts_into_bins(counts: Mapping[int, int], *, by_decades: bool) -> dict[str, int]:
    """Return the number of items in each bin (range of values), by a label of the bin such as ``5-9``.

    Empty bins between other bins are included.
    """
    if by_decades:
        powers = range(len(str(max(counts))))
        return {
            _label_decade(power): sum(n for value, n in counts.items() if len(str(value)) == power + 1)
            for power in powers
        }
    width = next(width for width in (1, 2, 5, 10, 20, 50, 100, 10**9) if max(counts) // width < _MAX_BINS)
    bins = range(min(counts) // width, max(counts) // width + 1)
    return {
        _label_bin(number * width, width): sum(n for value, n in counts.items() if value // width == number)
        for number in bins
    }


def _label_decade(power: int) -> str:
    return f"{10**power:,}+" if power else "1-9"


def _label_bin(low: int, width: int) -> str:
    return str(low) if width == 1 else f"{low}-{low + width - 1}"


def _draw_bars(panel: Axes, item: _ValueDistribution) -> None:
    bins = group_counts_into_bins(item.counts, by_decades=item.decades)
    panel.bar(range(len(bins)), list(bins.values()), width=0.86, color=ACCENT)
    every = -(-len(bins) // 8)
    panel.set_xticks(range(0, len(bins), every), labels=list(bins)[::every], fontsize=7)
    panel.set_ylabel(item.unit)
    panel.set_axisbelow(True)
    panel.yaxis.grid(visible=True, color=RULE, linewidth=0.6)
    if len(bins) <= 8:
        for index, number in enumerate(bins.values()):
            panel.annotate(str(number), (index, number), ha="center", va="bottom", fontsize=6.5, color=INK)


def _draw_bar_per_named_value(panel: Axes, item: _ValueDistribution) -> None:
    shown = dict(list(item.counts.items())[:_MAX_NAMES])
    panel.barh(range(len(shown)), list(shown.values()), height=0.8, color=ACCENT)
    panel.set_yticks(range(len(shown)), labels=[clip_label(name) for name in shown], fontsize=6.2)
    panel.set_ylim(max(len(shown), 1) - 0.4, -0.6)
    panel.tick_params(axis="y", length=0)
    some = (
        "" if len(shown) == len(item.counts) else f" (the {len(shown)} most frequent of {len(item.counts)})"
    )
    panel.set_xlabel(f"{item.unit}{some}")
