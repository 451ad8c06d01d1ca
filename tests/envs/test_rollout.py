"""Rollouts: what an episode is worth is what its actions would be paid as a plan, faults aside."""

from __future__ import annotations

import pytest

import eai
from eai.data.store import Store
from eai.envs.game import Stage
from eai.envs.rollout import Rollout, stage_of
from eai.envs.rules import Feedback, Rules
from eai.errors import InputError
from eai.scoring.reward import METRICS
from envs.switches import SWITCHES, WON, tasks

PLAYED = Rules(max_steps=8)


def rollout(*commands: str, shaping: str = "progress") -> Rollout:
    started = Rollout(Stage(tasks()[0], SWITCHES, PLAYED), shaping, PLAYED)
    for command in commands:
        started.act(command)
    return started


@pytest.mark.parametrize(
    ("commands", "worth"),
    [
        ((), {"success": 0, "goals": 0, "progress": 0, "diagnosis": 0}),
        (("PRESS(lamp)",), {"success": 0, "goals": 0.5, "progress": 0.5, "diagnosis": 0.5}),
        (("PRESS(lamp)", "PRESS(lamp)"), {"success": 0, "goals": 0, "progress": 0, "diagnosis": 0}),
        (
            ("OPEN(box)", "PRESS(lamp)", "?"),
            {"success": 0, "goals": 0.5, "progress": 0.5, "diagnosis": 1 / 6},
        ),
        (WON, dict.fromkeys(("success", "goals", "progress", "diagnosis"), 1)),
        (("?", *WON), {"success": 1, "goals": 1, "progress": 1, "diagnosis": 0.5}),
    ],
)
def test_an_episode_is_worth_what_it_gains(commands: tuple[str, ...], worth: dict[str, float]) -> None:
    assert {shaping: rollout(*commands, shaping=shaping).worth for shaping in worth} == worth


def test_faults_are_counted_by_kind() -> None:
    metrics = rollout("OPEN(box)", "FLY(lamp)", "FLY(box)", "PRESS(lamp)").metrics
    assert tuple(metrics) == METRICS
    told = {name: value for name, value in metrics.items() if value}
    assert told == {"progress": 0.5, "faults": 3, "fault.hallucination": 2, "fault.missing_step": 1}


def test_it_ends_when_it_is_won_or_has_lasted_long_enough() -> None:
    won = rollout(*WON)
    assert won.over
    with pytest.raises(InputError, match="the episode is over"):
        won.act("PRESS(lamp)")
    lasted = rollout(*["WAVE()"] * 7)
    assert not lasted.over
    assert lasted.act("WAVE()").truncated
    assert (lasted.over, lasted.worth) == (True, 0)


def test_the_opening_tells_of_the_world_and_of_the_task() -> None:
    opening = rollout().opening
    assert opening.startswith("You act in a symbolic world")
    assert "\n\nboth\nSwitch both on.\n\n" in opening


def test_a_named_task_is_made_ready_once(data_store: Store) -> None:
    task_id = eai.open("behavior", "action_sequencing").task_ids[0]
    task, brief = f"behavior/action_sequencing/{task_id}", Rules(feedback=Feedback.CHANGES)
    assert stage_of(task) is stage_of(task)
    assert stage_of(task, brief) is not stage_of(task)
    with pytest.raises(InputError, match="has no task"):
        stage_of("behavior/action_sequencing/none")
    with pytest.raises(InputError, match="only tasks of action_sequencing are played"):
        stage_of(f"behavior/goal_interpretation/{task_id}")
