"""OpenEnv environment of household tasks: a thin translation of `eai.agents.game.Game`."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from openenv.core.env_server import Environment
from openenv.core.env_server.types import Action, EnvironmentMetadata, Observation, State
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from eai.agents.game import Game
from eai.agents.reference import find_setup
from eai.agents.rules import TRAINING, GameRules
from eai.base.errors import InputError
from eai.tasks.options import describe_validation_error
from eai_openenv.meters import Meters
from eai_openenv.tasks import Tasks


class HouseholdAction(Action):
    """One action as text."""

    command: str = Field(description="The action with its objects on one line, such as OPEN(fridge.7).")

    @model_validator(mode="before")
    @classmethod
    def _restore_parsed_command(cls, value: Any) -> Any:
        """Turn a command in JSON back into text: some clients parse it and send an object."""
        is_command = not isinstance(value, dict) or "command" in value
        return value if is_command else {"command": json.dumps(value)}


class HouseholdObservation(Observation):
    """An observation for the agent; ``metadata`` is for those who monitor the episode."""

    text: str = Field(description="What became of the action, and what is seen now.")


class HouseholdState(State):
    """State of an episode."""

    task: str | None = Field(default=None, description="The task that is played.")
    over: bool = Field(default=True, description="Whether no action can be taken.")


class _ResetArguments(BaseModel):
    """Arguments of `reset`, validated because OpenEnv forwards whatever a client sends."""

    model_config = ConfigDict(strict=True)

    seed: int | None
    task: str | None
    split: str | None
    index: int | None


class Household(Environment[HouseholdAction, HouseholdObservation, HouseholdState]):
    """One session of a client: episodes one after the other, each of one task.

    The rewards of an episode's turns add up to the reward that `eai.Reward` pays for its actions.

    Args:
        tasks: Tasks that can be played.
        rules: Rules of the game and its reward.
        meters: Counters of episodes and turns.
    """

    SUPPORTS_CONCURRENT_SESSIONS: bool = True
    DESCRIPTION: ClassVar[str] = "Household tasks, played by text one action at a time."

    def __init__(
        self,
        tasks: Tasks,
        rules: GameRules = TRAINING,
        meters: Meters | None = None,
    ) -> None:
        super().__init__()
        self._tasks = tasks
        self._rules = rules
        self._meters = meters or Meters()
        self._game: Game | None = None
        self._state = HouseholdState()
        self._closed = False

    def reset(
        self,
        seed: int | None = None,
        episode_id: str | None = None,
        *,
        task: str | None = None,
        split: str | None = None,
        index: int | None = None,
        **others: Any,
    ) -> HouseholdObservation:
        """Begin an episode.

        Args:
            seed: Seed of slips, and of the random choice of a task.
            episode_id: The client's name of the episode.
            task: Reference of the task, as `Suite.reference` writes it.
            split: Split from which the task is chosen; None for the first split.
            index: Index of the task in the split, from 0; None for a random task.
            others: Other arguments, which raise an error.

        Raises:
            InputError: The task does not exist, or an argument is wrong.
        """
        if others:
            raise InputError(f"reset: expected task, split, index or seed, not {', '.join(sorted(others))}")
        try:
            _ResetArguments(seed=seed, task=task, split=split, index=index)
        except ValidationError as error:
            raise InputError(f"reset: {describe_validation_error(error)}") from error
        self._refuse_if_closed()
        chosen = self._tasks.choose_task(task, split, index, seed)
        self._game = Game(find_setup(chosen, self._rules), seed or 0)
        self._state = HouseholdState(episode_id=episode_id, task=chosen, over=False)
        self._meters.count_episode_start()
        return HouseholdObservation(
            text=self._game.write_manual_and_first_observation(), metadata={"task": chosen}
        )

    def step(
        self, action: HouseholdAction, timeout_s: float | None = None, **others: Any
    ) -> HouseholdObservation:
        """Play one turn. A turn takes milliseconds, so `timeout_s` is ignored.

        Raises:
            InputError: No episode has begun, or the last one is over.
        """
        self._refuse_if_closed()
        if self._game is None:
            raise InputError("no episode has begun: call reset first, in the same WebSocket session")
        turn = self._game.act(action.command)
        over = self._game.is_over
        self._state.step_count += 1
        self._state.over = over
        self._meters.count_turn(turn.info["fault"])
        metadata: dict[str, Any] = {"fault": turn.info["fault"]}
        if over:
            self._meters.count_episode_end(won=turn.info["won"])
            metadata["metrics"] = dict(self._game.metrics)
        return HouseholdObservation(text=turn.observation, reward=turn.reward, done=over, metadata=metadata)

    async def reset_async(
        self, seed: int | None = None, episode_id: str | None = None, **kwargs: Any
    ) -> HouseholdObservation:
        """Begin an episode without a thread, because `reset` takes only milliseconds."""
        return self.reset(seed, episode_id, **kwargs)

    async def step_async(
        self, action: HouseholdAction, timeout_s: float | None = None, **kwargs: Any
    ) -> HouseholdObservation:
        """Play one turn without a thread, because a change of threads takes longer than `step`."""
        return self.step(action, timeout_s, **kwargs)

    @property
    def state(self) -> HouseholdState:
        """Return the state of the episode."""
        return self._state

    def close(self) -> None:
        """End the session. The server also calls this after the idle limit."""
        self._closed = True
        self._game = None

    def _refuse_if_closed(self) -> None:
        if self._closed:
            raise InputError("the session is closed: it ended or was idle for too long; open a new one")

    def get_metadata(self) -> EnvironmentMetadata:
        """Return the server's name, description and version."""
        return EnvironmentMetadata(name="eai", description=self.DESCRIPTION, version="0.1.0")

    def list_splits(self) -> list[str]:
        """Return the names of the splits, in order."""
        return list(self._tasks.splits)

    def num_tasks(self, split: str) -> int:
        """Return the number of tasks of a split that can be played."""
        return len(self._tasks.list_references(split))

    def get_task(self, split: str, index: int) -> dict[str, Any]:
        """Return a task's index, its reference for `reset`, and its instruction."""
        tasks = self._tasks.list_references(split)
        if not 0 <= index < len(tasks):
            raise IndexError(index)
        return {
            "index": index,
            "task": tasks[index],
            "instruction": self._tasks.get_instruction(split, tasks[index]),
        }

    def get_task_range(
        self, split: str, start: int | None = None, stop: int | None = None
    ) -> list[dict[str, Any]]:
        """Return the tasks of a range of indices, which counts like a Python slice."""
        return [self.get_task(split, i) for i in range(self.num_tasks(split))[start:stop]]

    def list_tasks(self, split: str) -> list[dict[str, Any]]:
        """Return the tasks of a split, at most the first thousand."""
        return self.get_task_range(split, 0, 1000)
