"""Draw the radar plot of a report: the main results of models in all abilities and domains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability, get_ability_sort_key
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results.plots import INK, MODEL_COLORS, MUTED, PAGE, RULE, SOFT, clip_label, make_figure
from eai.studies.report.run_summary import RunSummary, select_runs_with_standard_rules_and_no_study
from eai.studies.report.table_specs import format_ability_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.projections.polar import PolarAxes

_MIN_AXES = 3
"""Minimum number of axes of a radar chart: a line through the points on two axes encloses no area."""

_MAX_MODELS_WITH_INTERVALS = 3
"""Maximum number of models in the plot for which intervals are drawn."""

_HEIGHT = 3.3
"""Height of a panel with the results of one domain, in inches."""

_LEGEND_ROW = 0.17

_Axis: TypeAlias = tuple[Ability, str]
"""An axis of the plot: an ability and one of the ability's main metrics."""

_Results: TypeAlias = Mapping[_Axis, RunSummary]
"""Results of a model in a domain: for each axis of the plot, the run whose result the axis shows."""


def draw_radar(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw the main results of runs under one protocol (scoring rules), one panel per domain.

    Runs with options of studies or changed game rules are left out, and so are domains with fewer than three
    metrics. The result is None if no domain remains. The nine models with the highest means have colours, all
    others are grey. If there are at most three models, bands show 95 % intervals.
    """
    worlds = {domain: _group_results_by_model(items) for domain, items in _group_by_domain(runs).items()}
    worlds = {domain: models for domain, models in worlds.items() if len(_list_axes(models)) >= _MIN_AXES}
    if not worlds:
        return None
    ranked = _rank_models(worlds)
    colors = dict(zip(ranked, MODEL_COLORS, strict=False))
    rows = math.ceil((min(len(ranked), len(MODEL_COLORS)) + 1) / 3)
    figure = make_figure(max(PAGE * len(worlds) / 2, PAGE / 2), _HEIGHT + _LEGEND_ROW * rows)
    panels = figure.subplots(1, len(worlds), squeeze=False, subplot_kw={"projection": "polar"})[0]
    for panel, (domain, models) in zip(panels, worlds.items(), strict=True):
        panel.set_title(get_title(domain), fontsize=9.5, pad=14)
        _draw_radar_panel(panel, models, colors, intervals=len(ranked) <= _MAX_MODELS_WITH_INTERVALS)
    _draw_legend(figure, ranked, colors)
    return figure


def _group_by_domain(runs: Sequence[RunSummary]) -> dict[str, list[RunSummary]]:
    return group_pairs((item.key.domain, item) for item in select_runs_with_standard_rules_and_no_study(runs))


def _group_results_by_model(runs: Sequence[RunSummary]) -> dict[str, _Results]:
    """Return the results in a domain by model, in the order of the runs."""
    models: dict[str, dict[_Axis, RunSummary]] = {}
    for item in runs:
        for metric in get_declaration(item.key.ability).averaged_metrics:
            if metric in item.rates and item.rates[metric].percent is not None:
                models.setdefault(item.key.name, {})[item.key.ability, metric] = item
    return dict(models)


def _list_axes(models: Mapping[str, _Results]) -> list[_Axis]:
    axes = dict.fromkeys(axis for results in models.values() for axis in results)
    return sorted(axes, key=lambda axis: get_ability_sort_key(axis[0]))


def _rank_models(results_by_domain: Mapping[str, Mapping[str, _Results]]) -> list[str]:
    """Return the names of models, sorted by the mean percentage of their results, highest first."""
    percents = group_pairs(
        (model, item.rates[metric].percent or 0.0)
        for models in results_by_domain.values()
        for model, results in models.items()
        for (_, metric), item in results.items()
    )
    return sorted(percents, key=lambda model: (-fmean(percents[model]), model))


def _draw_radar_panel(
    panel: PolarAxes, models: Mapping[str, _Results], colors: Mapping[str, str], *, intervals: bool
) -> None:
    axes = _list_axes(models)
    angles = [2 * math.pi * number / len(axes) for number in range(len(axes))]
    panel.set_theta_zero_location("N")
    panel.set_theta_direction(-1)
    panel.set(ylim=(0, 100), yticks=[25, 50, 75, 100])
    panel.set_yticklabels(["25", "50", "75", "100 %"], fontsize=5.5, color=SOFT)
    panel.set_rlabel_position(math.degrees(angles[1]) / 2)
    panel.set_xticks(angles, labels=[_make_axis_label(axis) for axis in axes], fontsize=6.5, color=INK)
    panel.tick_params(axis="x", pad=1)
    for angle, label in zip(angles, panel.get_xticklabels(), strict=True):
        side = math.sin(angle)
        label.set_horizontalalignment("center" if abs(side) < 0.1 else "left" if side > 0 else "right")
    panel.grid(color=RULE, linewidth=0.6)
    panel.spines["polar"].set_color(RULE)
    for model in sorted(models, key=lambda model: model in colors):
        results, color = models[model], colors.get(model, MUTED)
        points = [(angle, axis) for angle, axis in zip(angles, axes, strict=True) if axis in results]
        values = [results[axis].rates[axis[1]].percent or 0.0 for _, axis in points]
        around = [angle for angle, _ in points]
        width, alpha = (1.2, 1.0) if model in colors else (0.6, 0.6)
        closed = [*around, *around[:1]], [*values, *values[:1]]
        panel.plot(*closed, "o-", color=color, linewidth=width, alpha=alpha, markersize=2.5)
        if intervals:
            _draw_interval_band(
                panel, around, [results[axis] for _, axis in points], [a[1] for _, a in points], color
            )


def _draw_interval_band(
    panel: PolarAxes, angles: Sequence[float], runs: Sequence[RunSummary], metrics: Sequence[str], color: str
) -> None:
    """Draw the intervals of a model's results as a band around the model's line."""
    lows, highs = [], []
    for item, metric in zip(runs, metrics, strict=True):
        certainty, percent = item.certainties.get(metric), item.rates[metric].percent or 0.0
        low, high = (percent, percent) if certainty is None else certainty.interval
        lows.append(low)
        highs.append(high)
    around = [*angles, *angles[:1]]
    panel.fill_between(around, [*lows, *lows[:1]], [*highs, *highs[:1]], color=color, alpha=0.15, linewidth=0)


def _make_axis_label(axis: _Axis) -> str:
    """Return the label of an axis in short lines: title of the ability, and metric if it has several."""
    ability, metric = axis
    declared, title = get_declaration(ability), "\n".join(format_ability_title(ability).split())
    if len(declared.averaged_metrics) == 1:
        return title
    return f"{title}\n({declared.overview_headings[metric]})"


def _draw_legend(figure: Figure, ranked: Sequence[str], colors: Mapping[str, str]) -> None:
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color=color, label=clip_label(model)) for model, color in colors.items()]
    others = len(ranked) - len(colors)
    if others:
        noun = "model" if others == 1 else "models"
        handles.append(Line2D([], [], color=MUTED, linewidth=0.6, label=f"{others} {noun} with lower means"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False, fontsize=7)
