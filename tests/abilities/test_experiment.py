from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given

from eai.abilities.experiment import Experiment, StudySettings
from eai.abilities.replanning_options import ReplanningOptions
from eai.base.errors import InputError
from experiments import experiment
from results.random_records import EXPERIMENTS


@pytest.mark.parametrize(
    ("varied", "names", "label"),
    [
        (experiment(3, feedback="explained"), "replanning", "replans-3-restart-explained"),
        (experiment(2, feedback="kind", form="chat"), "replanning", "replans-2-restart-kind-chat"),
        (
            experiment(3, "continue", "state", slip=0.1, slip_seed=4, until="goal"),
            "replanning",
            "replans-3-continue-state+slip-0.1-seed-4+until-goal",
        ),
        (
            experiment(slip=0.05, slip_seed=0, notice="silent"),
            "replanning",
            "replans-0+slip-0.05-seed-0-silent",
        ),
        (experiment(goals_from="openai/gpt-4o"), "pipeline", "goals-openai_gpt-4o"),
        (experiment(1, goals_from="gpt-4o"), "pipeline replanning", "goals-gpt-4o+replans-1-restart-none"),
        (experiment(prompt_name="my prompt/2"), "prompts", "prompt-my_prompt_2"),
        (experiment(scene="noisy-0.1"), "perception", "scene-noisy-0.1"),
        (experiment(until="goal"), "replanning", "replans-0+until-goal"),
        (
            experiment(1, goals_from="m", scene="image", prompt_name="short", preset="eai-1.0.5"),
            "pipeline perception replanning prompts",
            "goals-m+scene-image+replans-1-restart-none+as-eai-1.0.5+prompt-short",
        ),
        (Experiment(rules="view-task_until-goal"), "", "rules-view-task_until-goal"),
        (Experiment(harness="react", effort="high"), "", "harness-react+effort-high"),
        (Experiment(), "", ""),
    ],
)
def test_an_experiment_lists_its_studies_and_has_a_label(varied: Experiment, names: str, label: str) -> None:
    assert (" ".join(varied.study_settings_in_label_order), varied.label) == (names, label)


def test_a_run_with_only_harness_and_effort_is_plain() -> None:
    assert Experiment(harness="react", effort="high").has_standard_rules_and_no_study_options
    assert not experiment(harness="react", prompt_name="short").has_standard_rules_and_no_study_options
    assert not Experiment(harness="react", rules="until-goal").has_standard_rules_and_no_study_options


def test_two_experiments_combine_their_choices() -> None:
    goals, scene = experiment(goals_from="m"), experiment(scene="image")
    assert goals.combine(scene) == scene.combine(goals) == experiment(goals_from="m", scene="image")
    assert goals.combine(goals) == goals
    with pytest.raises(InputError, match="pipeline: goals_from has two values in one run, m and other"):
        goals.combine(experiment(goals_from="other"))
    with pytest.raises(InputError, match="effort has two values in one run, high and low"):
        Experiment(effort="high").combine(Experiment(effort="low"))


def test_a_replaced_choice_keeps_its_position_in_the_label() -> None:
    choices = {
        name: StudySettings(name, label_position=place) for place, name in enumerate(("first", "second"))
    }
    changed = Experiment(choices).override_settings_with(
        Experiment({"first": StudySettings("other", label_position=9)})
    )
    assert changed.label == "other+second"


def test_dropping_the_only_choice_leaves_no_experiment() -> None:
    both = experiment(goals_from="m", scene="image")
    assert both.drop_options_of_study("perception") == experiment(goals_from="m")
    assert experiment(scene="image").drop_options_of_study("perception") is None


def test_the_label_of_studies_names_neither_harness_nor_effort() -> None:
    assert experiment(scene="image", effort="high").study_label == "scene-image"
    assert experiment(scene="image", rules="until-goal").study_label == "scene-image+rules-until-goal"
    assert Experiment(harness="react", effort="high").study_label == ""


@pytest.mark.parametrize(
    "wrong",
    [
        {"replans": -1},
        {"slip": 1.5},
        {"preset": ""},
        {"feedback": "state"},  # the initial state again
    ],
)
def test_options_of_replanning_that_are_out_of_range_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        ReplanningOptions(**wrong)


@pytest.mark.parametrize("name", ["prompt_name", "scene", "goals_from", "subgoals_from"])
def test_an_option_may_be_any_text_that_can_name_a_file(name: str) -> None:
    assert experiment(**{name: "a b"}).label.endswith("-a_b")
    for wrong in ("", ".."):
        with pytest.raises(InputError, match="no file can be named after"):
            experiment(**{name: wrong})


@pytest.mark.parametrize("label", ["", "a/b", "a++b", "..", "a b"])
def test_a_label_that_cannot_name_a_folder_is_refused(label: str) -> None:
    with pytest.raises(InputError):
        StudySettings(label)


@given(EXPERIMENTS)
def test_a_label_is_the_name_of_a_folder(varied: Experiment) -> None:
    assert not set(varied.label) & set("/\\ \0:")
