"""The plots of a report; figures are inspected, not rendered."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from eai.abilities.task_features import TaskFeatures
from eai.results.plots import PAGE
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.studies.report.plots import (
    add_plots_to_report,
    draw_answers_left_after_each_check,
    draw_executed_steps_or_f1_by_action,
    draw_outcomes,
    draw_reached_goals_or_f1_by_predicate,
    draw_success_by_difficulty,
)
from eai.studies.report.run_summary import RunSummary, summarize_run
from eai.world.fault import FaultKind
from results.verdicts import SUCCEEDED, failed, record
from studies.report.samples import action_run, goal_run

if TYPE_CHECKING:
    from matplotlib.figure import Figure

pytest.importorskip("matplotlib")

BAD = failed(FaultKind.AFFORDANCE)


def summary(records: Sequence[Record]) -> RunSummary:
    first = records[0]
    return summarize_run(
        Run(RunKey(first.protocol, first.domain, first.ability, first.model), tuple(records))
    )


def renamed(records: Sequence[Record], model: str) -> list[Record]:
    return [replace(each, model=model) for each in records]


def test_a_figure_has_its_suite_as_title(tmp_path: Path) -> None:
    page, runs = tmp_path / "report.md", [summary(action_run("m")), summary(goal_run())]
    page.write_text("# Results\n")
    told: list[int] = []
    drawn = add_plots_to_report(tmp_path, runs, (), ["svg"], lambda title, number: nullcontext(told.append))
    shown = {path.stem: path.read_text() for path in (tmp_path / "plots").glob("*.svg")}
    assert len(shown) == drawn < len(told)
    assert page.read_text().count("](plots/") == drawn
    assert {"outcomes-virtualhome-strict", "flow-action_sequencing-virtualhome-strict"} <= {*shown}
    for name, text in shown.items():
        assert "VirtualHome" in text, name
        assert "strict" in text, name


def test_bars_of_outcomes_show_the_number_of_answers() -> None:
    figure = draw_outcomes([summary([record("1_1", BAD), record("2_1", SUCCEEDED)])])
    assert figure is not None
    (panel,) = figure.axes
    assert [text.get_text().split() for text in panel.get_yticklabels()] == [["m", "2"]]
    assert [text.get_text() for text in panel.texts] == ["n"]


def of_length(steps: int | None, verdicts: Sequence[bool], goals: int = 1) -> list[Record]:
    return [
        replace(
            record(f"{steps}_{goals}_{i}", SUCCEEDED if right else BAD),
            task=TaskFeatures(f"{steps}", steps, goals),
        )
        for i, right in enumerate(verdicts)
    ]


def test_plan_lengths_are_annotated_steps_and_empty_bins_are_gaps() -> None:
    """Ten by ten, as in the paper; the task of 60 steps stands alone, with a hollow mark."""
    run = [
        *of_length(2, [True] * 6),
        *of_length(9, [False] * 2),
        *of_length(10, [True, False] * 3),
        *of_length(60, [True], goals=12),
        *of_length(None, [True], goals=15),
    ]
    figure = draw_success_by_difficulty([summary(run)])
    assert figure is not None
    goals, lengths = figure.axes
    assert [text.get_text() for text in lengths.get_xticklabels()] == ["0–9\n8", "10–19\n6", "60–69\n1"]
    assert [text.get_text() for text in goals.get_xticklabels()] == ["1\n14", "10+\n2"]
    heights = [float(y) for y in lengths.lines[0].get_ydata()]
    assert heights[:2] == [75, 50]
    assert all(map(math.isnan, heights[2:6]))
    assert heights[6] == 100
    hollow = [line for line in lengths.lines if line.get_markerfacecolor() == "white"]
    assert [list(line.get_xdata()) for line in hollow] == [[6]]
    assert len(lengths.collections) == 3  # an interval a bin


def test_many_models_have_lines_that_differ_without_colour_and_no_intervals() -> None:
    runs = [
        summary(renamed([*of_length(2, [True] * 6), *of_length(12, [False] * 6)], f"m{i}")) for i in range(9)
    ]
    figure = draw_success_by_difficulty(runs)
    assert figure is not None
    (panel,) = figure.axes
    assert len({line.get_marker() for line in panel.lines}) == 9
    assert not panel.collections


def test_old_records_have_no_plot_of_difficulty() -> None:
    old = [replace(each, task=None) for each in of_length(2, [True] * 9)]
    assert draw_success_by_difficulty([summary(old)]) is None
    assert summary(old).unnamed == 9


def test_labels_of_losses_do_not_overlap() -> None:
    """Few answers are lost to names, and many to the next stage: both labels would be on one line."""
    unknown = failed(FaultKind.HALLUCINATION)
    run = [*of_length(3, [True] * 50 + [False] * 48), *[record(f"x{i}_1", unknown) for i in range(2)]]
    figure = draw_answers_left_after_each_check([summary(run)])
    assert figure is not None
    (panel,) = figure.axes
    heights = [
        text.get_position()[1]
        for text in panel.texts
        if text.get_text()[-1].isdigit() and " " in text.get_text()
    ]
    assert len(heights) == 2
    assert abs(heights[0] - heights[1]) >= 9


@pytest.mark.parametrize("draw", [draw_executed_steps_or_f1_by_action, draw_reached_goals_or_f1_by_predicate])
def test_matrices_of_many_models_fit_a_page(
    draw: Callable[[Sequence[RunSummary]], Figure | None],
) -> None:
    runs = [summary(renamed(action_run("all"), f"a-model-with-a-long-name-{i}")) for i in range(18)]
    figure = draw(runs)
    assert figure is not None
    assert figure.get_figwidth() <= PAGE
    assert draw([summary([record("1_1", BAD)])]) is None
