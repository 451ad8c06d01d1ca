"""The radar of a report; figures are inspected, not rendered."""

from __future__ import annotations

from dataclasses import replace

import pytest

from eai.abilities.experiment import Experiment
from eai.results.plots import MODEL_COLORS
from eai.results.record import Record
from eai.results.runs import Run, RunKey
from eai.studies.report.plot_radar import draw_radar
from eai.studies.report.run_summary import RunSummary, summarize_run
from experiments import experiment
from studies.report.samples import action_run, goal_run, operator_run, subgoal_run

pytest.importorskip("matplotlib")
np = pytest.importorskip("numpy")


def summaries(model: str, *, experiment: Experiment | None = None) -> list[RunSummary]:
    """The runs of a model in all abilities of one world."""
    found = []
    for records in (goal_run(), subgoal_run(), action_run(), operator_run()):
        own = [replace(each, model=model, domain="virtualhome", experiment=experiment) for each in records]
        found.append(summarize_run(Run(key_of(own[0]), tuple(own))))
    return found


def key_of(first: Record) -> RunKey:
    return RunKey(first.protocol, first.domain, first.ability, first.model, first.experiment)


def test_the_axes_of_a_radar_are_the_metrics_of_the_average() -> None:
    runs = summaries("m")
    figure = draw_radar(runs)
    assert figure is not None
    (panel,) = figure.axes
    labels = [" ".join(text.get_text().split()) for text in panel.get_xticklabels()]
    assert labels[:3] == ["Goal interpretation", "Subgoal decomposition", "Action sequencing"]
    assert all(label.startswith("Transition modeling (") for label in labels[3:])
    (line,) = panel.lines
    values = [float(value) for value in np.asarray(line.get_ydata())]
    assert values[0] == values[-1] == runs[0].rates["overall.f1"].percent
    assert values[2] == runs[2].rates["task_success"].percent


def test_models_beyond_the_colours_are_grey_and_counted() -> None:
    runs = [run for number in range(len(MODEL_COLORS) + 2) for run in summaries(f"model {number:02}")]
    figure = draw_radar(runs)
    assert figure is not None
    named = [text.get_text() for text in figure.legends[0].get_texts()]
    assert named == [
        *[f"model {number:02}" for number in range(len(MODEL_COLORS))],
        "2 models with lower means",
    ]


def test_experiments_and_worlds_with_two_results_have_no_radar() -> None:
    assert draw_radar([run for run in summaries("m") if run.key.ability.value == "action_sequencing"]) is None
    assert draw_radar(summaries("m", experiment=experiment(scene="image"))) is None
    assert draw_radar([]) is None
