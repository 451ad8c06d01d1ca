"""A radar per model: the columns of the paper's overview as axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from eai.abilities.declaration import declaration_of, the_four
from eai.report.run_summary import RunSummary
from eai.results.palette import ACCENT, MUTED, RULE
from eai.results.plot_text import clipped

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

_PER_ROW = 3
_SIDE = 2.35
_FEWEST_AXES = 3


def draw(runs: Sequence[RunSummary]) -> Figure | None:
    """The models of one domain and protocol side by side; None if they have too few axes to span an area."""
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

    values = _values(runs)
    labels = _labels()
    axes = [name for name in labels if any(name in known for known in values.values())]
    if len(axes) < _FEWEST_AXES:
        return None
    columns = min(_PER_ROW, len(values))
    rows = -(-len(values) // columns)
    figure = Figure(figsize=(_SIDE * columns, _SIDE * rows * 1.08), layout="constrained")
    for place, (model, known) in enumerate(values.items(), 1):
        panel = figure.add_subplot(rows, columns, place, projection="polar")
        assert isinstance(panel, PolarAxes)  # noqa: S101 - what the projection gives
        _draw_model(panel, model, {labels[name]: known.get(name) for name in axes})
    return figure


def _labels() -> Mapping[str, str]:
    """The main metrics by ability and name, as they are called at the end of an axis."""
    return {
        f"{ability.value}/{metric}": f"{declared.short}\n{label if label.isupper() else label.lower()}"
        for ability, declared in the_four().items()
        for metric, label in declared.main.items()
    }


def _values(runs: Sequence[RunSummary]) -> Mapping[str, Mapping[str, float]]:
    found: dict[str, dict[str, float]] = {}
    for item in runs:
        for metric in declaration_of(item.key.ability).main:
            percent = item.rates[metric].percent if metric in item.rates else None
            if percent is not None:
                found.setdefault(item.key.model, {})[f"{item.key.ability.value}/{metric}"] = percent
    return dict(sorted(found.items()))


def _draw_model(panel: PolarAxes, model: str, values: Mapping[str, float | None]) -> None:
    """What is not known has no mark; the line is broken there, and without a whole line there is no area."""
    angles = [2 * math.pi * i / len(values) for i in range(len(values))]
    panel.set_theta_offset(math.pi / 2)
    panel.set_theta_direction(-1)
    panel.set_ylim(0, 100)
    panel.set_yticks([25, 50, 75, 100], labels=["", "50", "", "100"], color=MUTED, fontsize=6)
    labels = [label if value is not None else f"{label}\n(none)" for label, value in values.items()]
    panel.set_xticks(angles, labels=labels, fontsize=6.5)
    panel.grid(color=RULE, linewidth=0.7)
    panel.spines["polar"].set_color(RULE)
    heights = [math.nan if value is None else value for value in values.values()]
    around, closed = [*angles, angles[0]], [*heights, heights[0]]
    panel.plot(around, closed, "o-", color=ACCENT, linewidth=1.4, markersize=2.6)
    if None not in values.values():
        panel.fill(around, closed, color=ACCENT, alpha=0.16)
    panel.set_title(clipped(model), fontsize=8.5, pad=12, loc="center")
