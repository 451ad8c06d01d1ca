from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given

from abilities.random_records import EXPERIMENTS
from eai.abilities.experiment import Experiment, Feedback, FeedbackForm, World, chosen_experiment
from eai.errors import InputError
from eai.world.episode import Notice, Until


@pytest.mark.parametrize(
    ("experiment", "name", "label"),
    [
        (Experiment(3, feedback=Feedback.EXPLAINED), "replanning", "replans-3-restart-explained"),
        (
            Experiment(2, feedback=Feedback.KIND, form=FeedbackForm.CHAT),
            "replanning",
            "replans-2-restart-kind-chat",
        ),
        (
            Experiment(3, World.CONTINUE, Feedback.STATE, slip=0.1, slip_seed=4, until=Until.GOAL),
            "replanning",
            "replans-3-continue-state+slip-0.1-seed-4+until-goal",
        ),
        (
            Experiment(slip=0.05, slip_seed=0, notice=Notice.SILENT),
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
        (Experiment(until=Until.GOAL), "replanning", "replans-0+until-goal"),
        (
            Experiment(1, goals_from="m", scene="image", prompt_name="short", preset="eai-1.0.5"),
            "pipeline+perception+replanning+prompts",
            "goals-m+scene-image+replans-1-restart-none+prompt-short+as-eai-1.0.5",
        ),
        (Experiment(), "", ""),
    ],
)
def test_names_and_labels(experiment: Experiment, name: str, label: str) -> None:
    assert (experiment.name, experiment.label) == (name, label)


def test_what_is_out_of_range() -> None:
    for wrong in (
        {"replans": -1},
        {"slip": 1.5},
        {"prompt_name": ".."},
        {"prompt_name": ""},
        {"scene": "."},
        {"feedback": Feedback.STATE},  # which is the initial one again
    ):
        with pytest.raises(InputError):
            replace(Experiment(), **wrong)


@given(EXPERIMENTS)
def test_a_label_is_the_name_of_a_folder(experiment: Experiment) -> None:
    assert not set(experiment.label) & set("/\\ \0:")


USUAL = {
    "replans": 0,
    "world": "restart",
    "feedback": None,
    "form": "prompt",
    "slip": 0.0,
    "slip_seed": 7,
    "notice": "detected",
    "until": None,
}
"""What stands for no choice."""


@pytest.mark.parametrize(
    ("choices", "experiment"),
    [
        ({}, None),
        # What cannot matter is as in a plain run:
        ({"world": "continue", "form": "chat", "notice": "silent", "slip_seed": 3}, None),
        ({"feedback": "none", "until": "done"}, None),
        ({"replans": 1}, Experiment(1, feedback=Feedback.EXPLAINED)),
        ({"replans": 1, "feedback": "none", "form": "chat"}, Experiment(1)),
        ({"replans": 1, "form": "chat"}, Experiment(1, feedback=Feedback.EXPLAINED, form=FeedbackForm.CHAT)),
        (
            {"replans": 2, "world": "continue"},
            Experiment(2, World.CONTINUE, Feedback.EXPLAINED, until=Until.GOAL),
        ),
        (
            {"replans": 2, "world": "continue", "feedback": "state", "until": "done"},
            Experiment(2, World.CONTINUE, Feedback.STATE),
        ),
        ({"slip": 0.1}, Experiment(slip=0.1, slip_seed=7)),
        (
            {"slip": 0.1, "notice": "silent", "slip_seed": 0},
            Experiment(slip=0.1, slip_seed=0, notice=Notice.SILENT),
        ),
        ({"until": "goal"}, Experiment(until=Until.GOAL)),
    ],
)
def test_what_some_choices_come_to(choices: dict[str, Any], experiment: Experiment | None) -> None:
    assert chosen_experiment(**{**USUAL, **choices}) == experiment


@pytest.mark.parametrize(
    ("choices", "complaint"),
    [
        ({"feedback": "kind"}, "feedback kind: there is none without replans"),
        ({"replans": 1, "feedback": "explaned"}, "'explaned' is no feedback: expected one of none, kind, "),
        ({"world": "restarted"}, "'restarted' is no world: expected one of restart, continue"),
        ({"form": "letter"}, "'letter' is no form of feedback"),
        ({"notice": "loud"}, "'loud' is no notice of slips"),
        ({"until": "never"}, "'never' is no end of an attempt"),
        ({"replans": -1}, "replans: expected 0 or more, not -1"),
        (
            {"replans": 1, "feedback": "state"},
            "feedback of the state says nothing in a world that begins anew",
        ),
    ],
)
def test_choices_that_contradict_each_other_or_are_unknown(choices: dict[str, Any], complaint: str) -> None:
    with pytest.raises(InputError) as caught:
        chosen_experiment(**{**USUAL, **choices})
    assert str(caught.value).startswith(complaint)
