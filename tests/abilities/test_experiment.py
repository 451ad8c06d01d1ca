from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given

from eai.abilities.experiment import Experiment
from eai.base.errors import InputError
from results.random_records import EXPERIMENTS


@pytest.mark.parametrize(
    ("experiment", "name", "label"),
    [
        (Experiment(3, feedback="explained"), "replanning", "replans-3-restart-explained"),
        (
            Experiment(2, feedback="kind", form="chat"),
            "replanning",
            "replans-2-restart-kind-chat",
        ),
        (
            Experiment(3, "continue", "state", slip=0.1, slip_seed=4, until="goal"),
            "replanning",
            "replans-3-continue-state+slip-0.1-seed-4+until-goal",
        ),
        (
            Experiment(slip=0.05, slip_seed=0, notice="silent"),
            "replanning",
            "replans-0+slip-0.05-seed-0-silent",
        ),
        (Experiment(goals_from="openai/gpt-4o"), "pipeline", "goals-openai_gpt-4o"),
        (
            Experiment(1, goals_from="gpt-4o"),
            "pipeline+replanning",
            "goals-gpt-4o+replans-1-restart-none",
        ),
        (Experiment(prompt_name="my prompt/2"), "prompts", "prompt-my_prompt_2"),
        (Experiment(scene="noisy-0.1"), "perception", "scene-noisy-0.1"),
        (Experiment(until="goal"), "replanning", "replans-0+until-goal"),
        (
            Experiment(1, goals_from="m", scene="image", prompt_name="short", preset="eai-1.0.5"),
            "pipeline+perception+replanning+prompts",
            "goals-m+scene-image+replans-1-restart-none+prompt-short+as-eai-1.0.5",
        ),
        (Experiment(rules="view-task_until-goal"), "rules", "rules-view-task_until-goal"),
        (Experiment(harness="react", effort="high"), "agent", "harness-react+effort-high"),
        (Experiment(), "", ""),
    ],
)
def test_names_and_labels(experiment: Experiment, name: str, label: str) -> None:
    assert (experiment.name, experiment.label) == (name, label)


def test_a_run_that_differs_by_harness_and_effort_alone_is_plain() -> None:
    assert Experiment(harness="react", effort="high").is_plain
    assert not Experiment(harness="react", prompt_name="short").is_plain
    assert not Experiment(harness="react", rules="until-goal").is_plain


def test_choices_of_two_experiments_are_combined() -> None:
    goals, scene = Experiment(goals_from="m"), Experiment(scene="image")
    assert goals.combined(scene) == scene.combined(goals) == Experiment(goals_from="m", scene="image")
    assert goals.combined(goals) == goals
    with pytest.raises(InputError, match="goals_from: one study chooses m, another one other"):
        goals.combined(Experiment(goals_from="other"))


def test_an_experiment_without_its_only_choice_is_none() -> None:
    both = Experiment(goals_from="m", scene="image")
    assert both.without("scene") == Experiment(goals_from="m")
    assert both.without("scene", "goals_from") is None


def test_the_label_of_studies_names_neither_harness_nor_effort() -> None:
    assert Experiment(scene="image", effort="high").study_label == "scene-image"
    assert Experiment(harness="react", effort="high").study_label == ""


def test_what_is_out_of_range() -> None:
    for wrong in (
        {"replans": -1},
        {"slip": 1.5},
        {"prompt_name": ".."},
        {"prompt_name": ""},
        {"scene": "."},
        {"goals_from": ""},
        {"subgoals_from": ".."},
        {"preset": ""},
        {"feedback": "state"},  # which is the initial one again
    ):
        with pytest.raises(InputError):
            replace(Experiment(), **wrong)


@given(EXPERIMENTS)
def test_a_label_is_the_name_of_a_folder(experiment: Experiment) -> None:
    assert not set(experiment.label) & set("/\\ \0:")
