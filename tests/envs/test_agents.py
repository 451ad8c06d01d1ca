from __future__ import annotations

import pytest

from eai.envs import make
from eai.envs.agents import RandomAgent
from eai.errors import InputError
from envs.switches import SWITCHES


def played(seed: int) -> list[str]:
    """What the random agent does."""
    env, agent = make(SWITCHES, task_id="both", admissible=True, max_steps=40), RandomAgent(seed)
    observation, info = env.reset(seed=0)
    commands, ended = [], False
    while not ended:
        commands.append(agent(observation, info))
        assert commands[-1] in info["admissible_commands"]
        observation, _, terminated, truncated, info = env.step(commands[-1])
        ended = terminated or truncated
    return commands


def test_the_random_agent_takes_admissible_commands_by_its_seed() -> None:
    assert played(1) == played(1)
    assert len({tuple(played(seed)) for seed in range(4)}) > 1


def test_it_has_to_be_told_what_is_admissible() -> None:
    with pytest.raises(InputError, match="admissible=True"):
        RandomAgent()("", {})
