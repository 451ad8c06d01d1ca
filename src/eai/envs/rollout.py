"""Rollouts: a task played to its end, action by action, and what that is worth to a training loop."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from eai.abilities.protocol import Ability, member
from eai.abilities.verdict import PlanVerdict
from eai.envs.game import Game, Stage, Turn, manual
from eai.envs.rules import Rules
from eai.errors import InputError
from eai.scoring.reward import metrics_of, suite_of
from eai.scoring.shaping import Merit, Shaping, merit
from eai.tasks.task_reference import TaskReference
from eai.world.fault import FaultKind

RULES = Rules(max_steps=50)
"""How tasks are played where nothing else is asked for."""

_KEPT = 4096
"""How many tasks are kept ready; one takes some milliseconds to make."""


class Rollout:
    """One episode of a task, and what it is worth as `eai.Reward` defines it; every failed action is a fault.

    Args:
        stage: the task; that of a named one is `stage_of`.
        shaping: what the episode is paid for.
        rules: how it is played, as the stage was made. What they pay for each turn is no part of its worth.
        seed: of slips.

    Attributes:
        opening: all that an agent is told before its first action: of the world, and of the task.

    Raises:
        InputError: there is no such shaping.
    """

    def __init__(
        self, stage: Stage, shaping: Shaping | str = Shaping.SUCCESS, rules: Rules = RULES, seed: int = 0
    ) -> None:
        self._shaping = member(Shaping, shaping, "shaping")
        self._game = Game(stage, rules, seed, epoch=0)
        observation, info = self._game.opening()
        self.opening = f"{manual(stage.benchmark, rules.feedback)}\n\n{observation}"
        self._at_start = self._reached = info["goals"]
        self._faults: Counter[FaultKind] = Counter()

    @property
    def over(self) -> bool:
        """Whether the episode has ended."""
        return self._game.over

    def act(self, command: str) -> Turn:
        """Play one turn, whatever the text.

        Raises:
            InputError: the episode has ended.
        """
        if self.over:
            raise InputError("the episode is over")
        turn = self._game.act(command)
        self._reached = turn.info["goals"]
        if turn.info["fault"] is not None:
            self._faults[FaultKind(turn.info["fault"])] += 1
        return turn

    @property
    def worth(self) -> float:
        """What the episode is worth if it ends now; 0 where nothing can be earned."""
        earned = self._earned()
        return 0.0 if earned is None else earned.worth(self._shaping)

    @property
    def metrics(self) -> Mapping[str, float]:
        """Numbers to watch, as those of `eai.scoring.reward.Grade`."""
        return metrics_of(self._earned())

    def _earned(self) -> Merit | None:
        reached = tuple(self._reached)
        verdict = PlanVerdict(
            executable=True, success=all(reached), additional_steps=0, goals_satisfied=reached
        )
        earned = merit(verdict, self._at_start)
        return None if earned is None else replace(earned, faults=self._faults)


@lru_cache(_KEPT)
def stage_of(task: str, rules: Rules = RULES) -> Stage:
    """A named task made ready to be played.

    Args:
        task: the task, of action sequencing, as `Suite.reference` writes it.
        rules: how it is played.

    Raises:
        InputError: there is no such task, or it cannot be played.
        DataError: the data cannot be had.
    """
    reference = TaskReference.parse(task)
    if reference.ability is not Ability.ACTION_SEQUENCING:
        raise InputError(f"{task}: only tasks of {Ability.ACTION_SEQUENCING.value} are played")
    suite = suite_of(reference)
    if reference.task_id not in suite.tasks:
        raise InputError(f"{suite.domain} has no task {reference.task_id!r}")
    return Stage(suite.tasks[reference.task_id], suite.benchmark, rules)
