"""The verifiers taskset of tasks played step by step: the environment answers each action of the agent."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

import verifiers.v1 as vf
from pydantic import field_validator

from eai.abilities.protocol import Ability
from eai.agents.game import Game
from eai.agents.game_setup import GameSetup
from eai.agents.reference import find_setup, make_setup
from eai.agents.rewards import extract_answer
from eai.agents.rules import TRAINING, GameRules
from eai_verifiers.tasks import make_single_task_suite
from eai_verifiers.taskset import HouseholdConfig, HouseholdData, HouseholdTaskConfig, HouseholdTaskset

_MAX_CACHED_TASKS = 4096
"""Maximum number of generated tasks that a process keeps in its cache."""


class StepsTaskConfig(HouseholdTaskConfig):
    """Options of playing a task and of its reward."""

    rules: GameRules = TRAINING
    """Rules of a game, as `eai.agents.gym.make` takes them. Their reward is set by ``shaping``."""

    @field_validator("rules", mode="before")
    @classmethod
    def _limit_actions_by_default(cls, rules: Any) -> Any:
        return {"max_steps": TRAINING.max_steps, **rules} if isinstance(rules, Mapping) else rules


class StepsConfig(HouseholdConfig):
    """Choice of the tasks; the ability is action sequencing."""

    task: StepsTaskConfig = StepsTaskConfig()


class StepsTask(vf.Task[HouseholdData, vf.State, StepsTaskConfig]):
    """One task, whose reward the environment pays."""

    def start_game(self) -> Game:
        """Start an episode of the task."""
        rules = self.config.rules.model_copy(update={"reward": self.config.shaping})
        line = self.data.line
        setup = find_setup(self.data.task, rules) if line is None else _make_single_task_setup(line, rules)
        return Game(setup)


@lru_cache(_MAX_CACHED_TASKS)
def _make_single_task_setup(line: str, rules: GameRules) -> GameSetup:
    suite = make_single_task_suite(line, Ability.ACTION_SEQUENCING)
    return make_setup(suite.tasks[suite.task_ids[0]], suite.benchmark, rules)


class StepsTaskset(HouseholdTaskset, vf.Taskset[StepsTask, StepsConfig]):
    """Tasks of action sequencing. The prompt is the first observation."""

    def load(self) -> Iterator[StepsTask]:
        """Yield the tasks that can be played, in order."""
        for whole in super().load():
            task = StepsTask(whole.data, self.config.task)
            yield task.with_data(
                prompt=task.start_game().write_manual_and_first_observation(), system_prompt=None
            )


class StepsEnvConfig(vf.EnvConfig):
    """Configuration of the agent. It needs no sandbox, because no reply is executed."""

    agent: vf.AgentConfig = vf.AgentConfig(runtime=vf.SubprocessConfig())


class StepsEnv(vf.Env[StepsEnvConfig]):
    """Environment in which one agent acts until all goals are reached or its turns are used up."""

    async def run(self, task: StepsTask, agents: vf.Agents) -> None:
        """Play one episode, and record its value as the reward and its faults as metrics."""
        game = task.start_game()
        async with agents.agent.interaction(task) as interaction:
            segment = await interaction.turn()
            while not segment.terminated:
                turn = game.act(extract_answer(segment.last_reply))
                if game.is_over:
                    break
                segment = await interaction.turn(turn.observation)
        interaction.trace.record_reward("household", game.reward_if_ended_now)
        interaction.trace.record_metrics(game.metrics)
