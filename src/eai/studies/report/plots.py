"""Draw plots of runs for papers. Matplotlib is imported only when a plot is drawn.

Lines show success by number of goals, and by length of the annotated plan. Stacked bars show the outcomes of
each run's answers. Flows show how many answers remain after each stage of checks, and why other answers
failed. Matrices show shares by action and by predicate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from itertools import accumulate, groupby
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from eai.abilities.declaration import AnswerOutcome, get_display_name
from eai.abilities.protocol import Ability
from eai.base.files import to_file_name, write_files_atomically
from eai.base.grouping import group_pairs
from eai.benchmarks.registry import get_title
from eai.results import plots
from eai.results.batch import ProgressCallback
from eai.results.certainty import TaskRateContribution, TaskRateContributions
from eai.results.lines import MODEL
from eai.results.markdown import escape_markdown
from eai.results.plots import (
    FEW_CASES,
    MODEL_COLORS,
    OUTCOME_COLORS,
    RULE,
    clip_label,
    draw_line,
    make_figure,
)
from eai.results.rate import NOTHING, Rate
from eai.results.table import Cell, Estimate
from eai.studies.report import plot_summary
from eai.studies.report.plot_radar import draw_radar
from eai.studies.report.rankings import Ranking
from eai.studies.report.run_summary import RunSummary
from eai.studies.report.table_specs import format_ability_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DIFFICULTY = (
    "Success by number of goals and by length of the data set's own plan (below, how many tasks; marks of "
    "fewer than five are hollow; bars of up to three models are 95 % intervals)"
)


LENGTHS_PER_BIN = 10
"""Number of plan lengths in one bin: 0-9, 10-19 and so on, as in the paper's figure."""

_MAX_GOALS = 10
"""Number of goals at which the last bin of tasks begins; this bin has no upper limit."""

_MAX_MODELS_WITH_INTERVALS = 3
"""Maximum number of models in a panel for which intervals are drawn."""
_PANEL = (3.5, 2.5)
"""Width and height of a panel, in inches. The width is a column of a page, so that fonts keep their size."""
_LEGEND_ROW = 0.17
_LEGEND_COLUMNS = {1: 1, 2: 3}
"""Number of columns of a figure's legend, by the figure's number of panels."""
_MARKS = "os^Dv<>ph"
_STYLES = ("-", "--", ":", "-.")
_MODEL_DISTANCE = 0.09
"""Horizontal distance between the points of two models in a bin, if intervals are drawn, in bin widths."""

Bins = Mapping[int, TaskRateContributions]
"""Successes of one model by index of the bin, a range of goal counts or plan lengths. No bin is empty."""


_Plot: TypeAlias = "tuple[str, str, Callable[[], Figure | None]]"
"""Name of a plot's files without suffix, its caption, and a function that draws it, or None without data."""


def add_plots_to_report(
    folder: Path,
    runs: Sequence[RunSummary],
    summary_tables: Sequence[Ranking],
    formats: Sequence[str],
    show_progress: Callable[[str, int], AbstractContextManager[ProgressCallback]],
) -> int:
    """Draw all plots for which runs have numbers, and add them to the end of ``report.md``.

    Return the number of plots.

    No plot is clipped to an area, because nothing in a plot leaves its axes. Names of clipping areas in SVG
    files depend on digits that vary between runs of the layout solver, and equal input must give equal files.

    Args:
        folder: folder of the report.
        runs: the runs, sorted by the order of their keys.
        summary_tables: the tables for a summary page of each model; without tables there are no pages.
        formats: file formats of each plot, among `eai.results.plots.FORMATS`.
        show_progress: function that shows the progress.

    Raises:
        EaiError: matplotlib is not installed.
    """
    planned, shown = [*_make_summary_plots(summary_tables), *_make_run_plots(runs)], list[str]()
    with plots.use_plot_style(), show_progress("drawing plots", len(planned)) as progressed:
        (folder / "plots").mkdir(parents=True, exist_ok=True)
        for number, (name, caption, draw) in enumerate(planned, 1):
            figure = draw()
            if figure is not None:
                plots.write_figure(figure, folder / "plots" / name, formats, clips=False)
                shown.append(f"{caption}\n\n![{caption}](plots/{name}.{formats[0]})\n")
            progressed(number)
    page = folder / "report.md"
    if shown:
        write_files_atomically({page: "\n".join((f"{page.read_text(encoding='utf-8')}\n## Plots\n", *shown))})
    return len(shown)


def _make_summary_plots(tables: Sequence[Ranking]) -> Iterator[_Plot]:
    for model, protocol in plot_summary.list_models_and_protocols(tables):
        name = to_file_name(f"summary-{model}-{protocol.value}")
        caption = f"{escape_markdown(model)} on one page, protocol {protocol.value}"
        yield name, caption, partial(plot_summary.draw_model_summary, tables, model, protocol)


def _make_run_plots(runs: Sequence[RunSummary]) -> Iterator[_Plot]:
    for protocol, of_protocol in group_pairs((item.key.protocol, item) for item in runs).items():
        title = f"Main results of all abilities, protocol {protocol.value}"
        drawn = partial(_draw_with_title, f"{title}, percent", draw_radar, of_protocol)
        yield f"radar-{to_file_name(protocol.value)}", title, drawn
    for (protocol, domain), group in group_pairs((item.key[:2], item) for item in runs).items():
        suite = f"{get_title(domain)}, protocol {protocol.value}"
        name = to_file_name(f"{domain}-{protocol.value}")
        drawn = partial(_draw_with_title, suite, draw_outcomes, group)
        yield f"outcomes-{name}", f"Outcomes of answers: {suite}", drawn
        for ability, of_ability in group_pairs((item.key.ability, item) for item in group).items():
            title = f"{get_title(domain)} {format_ability_title(ability).lower()}, {protocol.value}"
            for kind, caption, draw in _OF_ABILITY:
                caption = f"{caption}: {format_ability_title(ability).lower()}, {suite}"
                drawn = partial(_draw_with_title, title, draw, of_ability)
                yield f"{kind}-{ability.value}-{name}", caption, drawn


def _draw_with_title(title: str, draw: _RunsPlotter, runs: Sequence[RunSummary]) -> Figure | None:
    figure = draw(runs)
    if figure is not None:
        plots.add_title(figure, title)
    return figure


def draw_success_by_difficulty(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw success by number of goals and by length of the annotated plan, a line per model.

    The result is None if both numbers are unknown or constant.
    """
    panels = [
        (
            "goals of the task",
            lambda goals: str(goals) if goals < _MAX_GOALS else f"{_MAX_GOALS}+",
            [
                _group_cases_by_bin(item.breakdown.by_goals, lambda goals: min(goals, _MAX_GOALS))
                for item in runs
            ],
        ),
        (
            "steps of the annotated plan",
            lambda number: f"{number * LENGTHS_PER_BIN}–{number * LENGTHS_PER_BIN + LENGTHS_PER_BIN - 1}",
            [
                _group_cases_by_bin(item.breakdown.by_length, lambda length: length // LENGTHS_PER_BIN)
                for item in runs
            ],
        ),
    ]
    panels = [panel for panel in panels if any(len(bins) > 1 for bins in panel[2])]
    if not panels:
        return None
    columns = min(_LEGEND_COLUMNS[len(panels)], len(runs))
    legend = _LEGEND_ROW * -(-len(runs) // columns)
    figure = make_figure(_PANEL[0] * len(panels), _PANEL[1] + legend)
    grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)[0]
    for panel, (label, name_of_bin, series) in zip(grid, panels, strict=True):
        panel.set_xlabel(label)
        _draw_line_panel(panel, name_of_bin, series, [clip_label(item.key.name) for item in runs])
    grid[0].set_ylabel("success in percent")
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=7)
    return figure


def _group_cases_by_bin(
    table: Mapping[int, TaskRateContributions], bin_of: Callable[[int], int]
) -> dict[int, list[TaskRateContribution]]:
    return group_pairs((bin_of(number), case) for number, cases in table.items() for case in cases)


def _draw_line_panel(
    panel: Axes, name_of_bin: Callable[[int], str], series: Sequence[Bins], models: Sequence[str]
) -> None:
    panel.set_ylim(-3, 103)
    panel.grid(axis="y", color=RULE, linewidth=0.7)
    numbers = sorted({number for bins in series for number in bins})
    tasks = [max(len(bins.get(number, ())) for bins in series) for number in numbers]
    labels = [f"{name_of_bin(number)}\n{count}" for number, count in zip(numbers, tasks, strict=True)]
    panel.set_xticks(numbers, labels=labels, fontsize=7)
    panel.text(-0.03, -0.115, "tasks", transform=panel.transAxes, fontsize=7, ha="right", va="top")
    for number, (bins, model) in enumerate(zip(series, models, strict=True)):
        color, mark = MODEL_COLORS[number % len(MODEL_COLORS)], _MARKS[number % len(_MARKS)]
        style = _STYLES[number // len(MODEL_COLORS) % len(_STYLES)]
        intervals = len(series) <= _MAX_MODELS_WITH_INTERVALS
        shift = _MODEL_DISTANCE * (number - (len(series) - 1) / 2) if intervals else 0.0
        all_bins = range(min(bins, default=0), max(bins, default=-1) + 1)
        cells = [Estimate.from_task_rate_contributions(bins.get(index, ())) for index in all_bins]
        hollow = [index + shift for index in bins if len(bins[index]) < FEW_CASES]
        at, line_style = [index + shift for index in all_bins], mark + style
        draw_line(panel, at, cells, color, line_style, hollow=hollow, intervals=intervals, label=model)


_WIDTH = 8.2
_BAR = 0.27
_HEAD = 0.62


def draw_outcomes(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw outcomes of runs of one domain and protocol (rules), one panel per ability; None without runs."""
    from matplotlib.patches import Patch

    panels = [list(items) for _, items in groupby(runs, key=lambda item: item.key.ability)]
    if not panels:
        return None
    heights = [_HEAD + _BAR * len(items) for items in panels]
    figure = make_figure(_WIDTH, sum(heights) + 0.55)
    grid = figure.subplots(len(panels), 1, squeeze=False, gridspec_kw={"height_ratios": heights})
    for panel, items in zip(grid[:, 0], panels, strict=True):
        _draw_outcome_panel(panel, items)
    kinds = [kind for kind in AnswerOutcome if any(_count_outcome(item, kind) for item in runs)]
    handles = [Patch(color=OUTCOME_COLORS[kind], label=get_display_name(kind.value)) for kind in kinds]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False, fontsize=7.5)
    return figure


def _draw_outcome_panel(panel: Axes, runs: Sequence[RunSummary]) -> None:
    panel.set_title(format_ability_title(runs[0].key.ability))
    panel.set_xlim(0, 100)
    panel.set_xticks([0, 25, 50, 75, 100], labels=["0", "25", "50", "75", "100 %"])
    answers = [sum(_count_outcome(item, kind) for kind in AnswerOutcome) for item in runs]
    labels = [
        f"{clip_label(item.key.name)}\u2002{number:,}" for item, number in zip(runs, answers, strict=True)
    ]
    panel.set_yticks(range(len(runs)), labels=labels)
    panel.text(-0.01, 1, "n", transform=panel.transAxes, fontsize=7.5, ha="right", va="bottom")
    panel.invert_yaxis()
    panel.tick_params(axis="y", length=0)
    panel.spines["left"].set_visible(False)
    for number, (item, scored) in enumerate(zip(runs, answers, strict=True)):
        widths = {kind: Rate(_count_outcome(item, kind), scored).percent or 0.0 for kind in AnswerOutcome}
        shown = {kind: width for kind, width in widths.items() if width}
        starts = accumulate(shown.values(), initial=0.0)
        bars = list(zip(starts, shown.values(), strict=False))
        colors = [OUTCOME_COLORS[kind] for kind in shown]
        panel.broken_barh(bars, (number - 0.37, 0.74), facecolors=colors, linewidth=0)


def _count_outcome(run: RunSummary, outcome: AnswerOutcome) -> int:
    return 0 if outcome is AnswerOutcome.EXCLUDED else run.breakdown.outcomes.get(outcome, 0)


_MAX_NAMES = 40
"""Maximum number of actions or predicates that fit a page."""

_F1 = "F1 of clauses, percent"


def draw_executed_steps_or_f1_by_action(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw the share of executed steps (or F1 of clauses) by action for each model; None without data."""
    label = {Ability.TRANSITION_MODELING: _F1}.get(runs[0].key.ability, "percent of steps executed")
    return _draw_rate_matrix_of_models({item.key.name: item.breakdown.by_action for item in runs}, label)


def draw_reached_goals_or_f1_by_predicate(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw the share of right goals (or F1 of clauses) by predicate for each model; None without data."""
    labels = {Ability.TRANSITION_MODELING: _F1, Ability.GOAL_INTERPRETATION: "percent of goals found"}
    label = labels.get(runs[0].key.ability, "percent of goals reached")
    return _draw_rate_matrix_of_models({item.key.name: item.breakdown.by_predicate for item in runs}, label)


def _draw_rate_matrix_of_models(models: Mapping[str, Mapping[str, Rate]], rate_label: str) -> Figure | None:
    rows: list[Mapping[str, Cell]] = []
    for name in _select_most_frequent_names(list(models.values())):
        for model, rates in models.items():
            rate = rates.get(name, NOTHING)
            rows.append({"name": name, MODEL: model, "share": Estimate.from_rate(rate)})
    return plots.draw_rate_matrix(rows, ("name",), "share", rate_label, shows_zero_rates=True)


def _select_most_frequent_names(columns: Sequence[Mapping[str, Rate]]) -> list[str]:
    """Return the most frequent names, sorted. The limit is needed because answers can contain many names."""
    cases: dict[str, float] = {}
    for column in columns:
        for name, rate in column.items():
            cases[name] = cases.get(name, 0) + rate.denominator
    return sorted(sorted(cases, key=lambda name: (-cases[name], name))[:_MAX_NAMES])


_FLOWS_PER_ROW = 2
_SIZE = (3.7, 2.0)
"""Width and height of a model's panel in the plot of answers that pass each check, in inches."""
_PANEL_DISTANCES = (6.1, 180.0)
"""Horizontal and vertical distance between the left upper corners of neighboring panels of models.

The horizontal axis has one unit per stage in `_STAGES`, the vertical axis one per percent of answers.
"""
_STAGES = ("answers", "parsed", "names known", "well formed", "executed", "goal reached")
_LOSSES = (
    ("unreadable", AnswerOutcome.PARSING),
    ("unknown names", AnswerOutcome.HALLUCINATION),
    ("argument number", AnswerOutcome.ARGUMENT_NUMBER),
    ("failed step", AnswerOutcome.MISSING_STEP),
    ("goal missed", AnswerOutcome.GOAL_MISSED),
)
_TOP = 100.0
_GAP = 9.0
"""Vertical distance between the answers that pass a check and the answers that fail it.

The figure shows both as bands. The unit is percent of answers.
"""
_LINE = 9.0
"""Height of a line of text in a figure, on the vertical axis, whose unit is one percent of answers.

A label that would overlap the previous label is moved below that label."""

_SMALLEST_LABELLED = 0.5


def draw_answers_left_after_each_check(runs: Sequence[RunSummary]) -> Figure | None:
    """Draw how many answers remain after each stage of checks, one panel per model.

    The result is None if the ability has no plans.
    """
    flows = [(item.key.name, flow) for item in runs if (flow := item.breakdown.flow) and flow["answers"]]
    if not flows:
        return None
    columns = min(_FLOWS_PER_ROW, len(flows))
    rows = -(-len(flows) // columns)
    left, top = -0.42, 139.0
    across, up = (left, left + _PANEL_DISTANCES[0] * columns), (top - _PANEL_DISTANCES[1] * rows, top)
    figure, panel = plots.make_canvas((_SIZE[0] * columns, _SIZE[1] * rows), across, up)
    for number, (model, flow) in enumerate(flows):
        row, column = divmod(number, columns)
        _draw_model_answers_left_after_checks(
            panel, (_PANEL_DISTANCES[0] * column, _TOP - _PANEL_DISTANCES[1] * row), model, flow
        )
    return figure


def _draw_model_answers_left_after_checks(
    panel: Axes, corner: tuple[float, float], model: str, flow: Mapping[str, int]
) -> None:
    """Draw the answers as a band from left to right; the failed share bends down after each stage."""
    shares = [Rate(count, flow["answers"]).percent or 0.0 for count in flow.values()]
    left, top = corner
    panel.text(left - 0.35, top + 27, clip_label(model), fontsize=9)
    before = top
    for stage, (label, kind) in enumerate(_LOSSES):
        at, passed, lost = left + stage, shares[stage + 1], shares[stage] - shares[stage + 1]
        plots.draw_flow_band(
            panel, at, (top - passed, top - passed, passed), OUTCOME_COLORS[AnswerOutcome.SUCCESS]
        )
        if lost >= _SMALLEST_LABELLED:
            end = top - passed - lost - _GAP
            plots.draw_flow_band(panel, at, (top - passed - lost, end, lost), OUTCOME_COLORS[kind])
            text = f"{label} {lost:.0f}"
            before = before - _LINE if abs(end - 5 - before) < _LINE else end - 5
            panel.text(at + 0.1, before, text, fontsize=6, va="center", color=plots.INK)
    for at, (name, share) in enumerate(zip(_STAGES, shares, strict=True)):
        panel.text(left + at, top + 4, f"{share:.0f}", fontsize=7.5, weight="bold", ha="center")
        panel.text(left + at, top + 15, name, fontsize=5.8, ha="center", color=plots.SOFT)


_RunsPlotter: TypeAlias = "Callable[[Sequence[RunSummary]], Figure | None]"

_OF_ABILITY: Sequence[tuple[str, str, _RunsPlotter]] = (
    ("flow", "From answer to outcome", draw_answers_left_after_each_check),
    ("difficulty", _DIFFICULTY, draw_success_by_difficulty),
    ("actions", "By action (of fewer than five cases in brackets)", draw_executed_steps_or_f1_by_action),
    (
        "predicates",
        "By predicate (of fewer than five cases in brackets)",
        draw_reached_goals_or_f1_by_predicate,
    ),
)
"""Plots of one ability's runs: name, caption, and a function that draws the plot, or None without data."""
