"""One reward: equal actions in a task earn equal rewards through all interfaces.

The tests of the packages for OpenEnv and verifiers use this table for their own interfaces.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import pytest

import eai
from agents.switches import CASES, CASES_BY_SHAPING, SWITCHES, WON, as_plan, reference, tasks
from eai import Shaping
from eai.agents.game import Game
from eai.agents.gym import make
from eai.agents.reference import make_setup
from eai.agents.rewards import SkyRlTask, TrlEnvironment, TrlReward, compute_score, reward_func
from eai.agents.rules import GameRules
from eai.base.errors import InputError
from eai.base.store import DataPackStore
from eai.results.reward import METRICS

Face = Callable[[str, Sequence[str], Shaping], float | None]


def of_plan(pay: Callable[[str, str, Shaping], float | None]) -> Face:
    """Return an interface that takes actions as one answer to a named task."""
    return lambda task_id, commands, shaping: pay(reference(task_id), as_plan(commands), shaping)


def of_openrlhf(task: str, text: str, shaping: Shaping) -> float:
    paid: float = reward_func([text], [""], [task], shaping=shaping)["rewards"]
    return paid


def of_skyrl(task: str, text: str, shaping: Shaping) -> float:
    extras = {"reward_spec": {"ground_truth": task}, "shaping": shaping.value}
    paid: float = SkyRlTask(None, extras).step(text)["reward"]
    return paid


def of_gymnasium(
    task_id: str, commands: Sequence[str], shaping: Shaping, *, until: str, gamma: float = 1.0
) -> float:
    environment = make(SWITCHES, task_id, reward=shaping.value, until=until, gamma=gamma)
    environment.reset(seed=0)
    played = [*commands, "DONE"] if until == "done" else commands
    return sum(gamma**turn * environment.step(command)[1] for turn, command in enumerate(played))


def of_trl_household(task_id: str, commands: Sequence[str], shaping: Shaping) -> float:
    household = TrlEnvironment(shaping)
    household.reset(task=reference(task_id))
    for command in commands:
        household.act(command)
    return household.get_reward()


FACES: dict[str, Face] = {
    "eai.reward": of_plan(eai.reward),
    "eai.Reward": lambda task_id, commands, shaping: eai.Reward(
        eai.open(SWITCHES, "action_sequencing"), shaping
    )(task_id, as_plan(commands)),
    "TrlReward": of_plan(lambda task, text, shaping: TrlReward(shaping)(completions=[text], task=[task])[0]),
    "verl": of_plan(lambda task, text, shaping: compute_score("eai", text, task, shaping=shaping)["score"]),
    "OpenRLHF": of_plan(of_openrlhf),
    "SkyRL": of_plan(of_skyrl),
    "gymnasium": partial(of_gymnasium, until="goal"),
    "gymnasium, ended by DONE": partial(of_gymnasium, until="done"),
    "TrlEnvironment": of_trl_household,
}


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize(("task_id", "commands", "shaping", "worth"), CASES_BY_SHAPING)
def test_equal_actions_earn_equal_rewards_through_all_interfaces(
    task_id: str, commands: Sequence[str], shaping: Shaping, worth: float, face: str
) -> None:
    assert FACES[face](task_id, commands, shaping) == pytest.approx(worth)


@pytest.mark.parametrize(("task_id", "commands", "shaping", "worth"), CASES_BY_SHAPING)
def test_discounted_rewards_add_up_to_the_final_value(
    task_id: str, commands: Sequence[str], shaping: Shaping, worth: float
) -> None:
    paid = of_gymnasium(task_id, commands, shaping, until="goal", gamma=0.9)
    assert paid == pytest.approx(0.9 ** len(commands) * worth)


def test_two_actions_in_a_household_earn_equal_rewards(data_store: DataPackStore) -> None:
    """Three of the five goals are not reached at first; the actions reach one of them."""
    commands = ("WALK(washing_machine.1001)", "SWITCHON(washing_machine.1001)")
    environment = make("virtualhome", "27_2", reward="progress")
    environment.reset(seed=0)
    played = sum(environment.step(command)[1] for command in commands)
    plan = '{"WALK": ["washing_machine", "1001"], "SWITCHON": ["washing_machine", "1001"]}'
    task = "virtualhome/action_sequencing/27_2"
    household = TrlEnvironment("progress")
    household.reset(task=task)
    list(map(household.act, commands))
    assert played == eai.reward(task, plan, "progress") == household.get_reward() == 1 / 3


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("shaping", list(Shaping))
def test_no_reward_is_paid_if_nothing_can_be_gained(shaping: Shaping, face: str) -> None:
    assert not FACES[face]("done", ("WAVE()",), shaping)


def played(*commands: str, shaping: Shaping = Shaping.PROGRESS) -> Game:
    game = Game(make_setup(tasks()[0], SWITCHES, GameRules(reward=shaping, max_steps=8)))
    for command in commands:
        game.act(command)
    return game


@pytest.mark.parametrize(
    ("commands", "worth"),
    [
        (("OPEN(box)", "PRESS(lamp)"), (0, 1 / 2, 1 / 2, 1 / 4, 1 / 3, 1 / 2)),
        (("OPEN(box)", "PRESS(lamp)", "?"), (0, 0, 1 / 2, 1 / 6, 1 / 3, 1 / 2)),
        (("?", "FLY", *WON), (1, 1, 1, 1 / 3, 1, 1)),
    ],
)
def test_an_episode_continues_after_a_failed_action(commands: Sequence[str], worth: Sequence[float]) -> None:
    """A plan would have ended there."""
    assert tuple(played(*commands, shaping=shaping).value for shaping in Shaping) == pytest.approx(worth)


def test_metrics_are_those_of_a_grade() -> None:
    suite = eai.open(SWITCHES, "action_sequencing")
    for task_id, commands, _ in CASES:
        if task_id == "both" and commands:  # an empty plan is an answer that cannot be read
            metrics = eai.Reward(suite).grade(task_id, as_plan(commands)).metrics
            assert played(*commands).metrics == metrics
    metrics = played("OPEN(box)", "FLY(lamp)", "FLY(box)", "PRESS(lamp)").metrics
    assert tuple(metrics) == METRICS
    told = {name: value for name, value in metrics.items() if value}
    assert told == {"progress": 0.5, "faults": 3, "fault.hallucination": 2, "fault.missing_step": 1}


def test_an_episode_that_is_over_takes_no_action() -> None:
    won = played(*WON)
    assert won.is_over
    with pytest.raises(InputError, match="the episode is over"):
        won.act("PRESS(lamp)")
    lasted = played(*["WAVE()"] * 8)
    assert (lasted.is_over, lasted.value) == (True, 0)
