"""Episodes in logs of other projects. Values that a log does not prove are None or "cannot tell"."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from eai.world.fault import FaultKind

CANNOT_TELL = "cannot tell"
"""Text for the kind of an error, or the outcome or ending of an episode, if the log does not prove it."""


class EpisodeOutcome(str, Enum):
    """The results of an episode. The values are the texts in tables.

    `WON` and `GOAL_UNMET` are verdicts of the project that wrote the log: of its grader, in its world. `eai`
    does not score logged episodes. `NOT_REPRODUCED` means that the grader's replay did not reproduce the
    episode. `NOT_GRADED` means that there is no verdict.
    """

    WON = "won"
    GOAL_UNMET = "goal unmet"
    NOT_REPRODUCED = "not reproduced"
    NOTHING_SUBMITTED = "nothing submitted"
    NOT_GRADED = "not graded"
    CANNOT_TELL = CANNOT_TELL


class EpisodeEndReason(str, Enum):
    """The reasons why an episode ended. The values are the texts in tables."""

    GOAL = "goal reached"
    BY_AGENT = "by the agent"
    OUT_OF_TIME = "out of time"
    OUT_OF_STEPS = "out of steps"
    TOO_MANY_ERRORS = "too many errors"
    STOPPED = "stopped from outside"
    CANNOT_TELL = CANNOT_TELL


class LoggedStep(NamedTuple):
    """One action of an agent.

    Attributes:
        action: the action, as the log writes it.
        accepted: whether the world carried out the action; None if the log does not show this.
        kind: the kind of error of a rejected action; None if the log does not prove a kind.
        feedback: the world's reply.
        progress: share of the goal's conditions that hold after the action; None if unknown.
    """

    action: str
    accepted: bool | None
    kind: FaultKind | None = None
    feedback: str = ""
    progress: float | None = None

    @property
    def is_error(self) -> bool:
        """Whether the world rejected the action. A slip (a failure by chance) is no error of the agent."""
        return self.accepted is False and self.kind is not FaultKind.SLIP


@dataclass(frozen=True, slots=True)
class LoggedEpisode:
    """An episode in a log.

    Attributes:
        task: name of the task in the log.
        outcome: the result of the episode.
        ending: the reason for the end of the episode.
        steps: the actions, in order; empty if the log shows only low-level control.
        agent: name of the agent; empty if unknown.
        setting: mode or setting of the episode; empty if the log has only one.
        opening: the first observation; empty if unknown.
        actions: number of actions; None if unknown.
        progress: share of the goal's conditions that hold at the end; None if unknown.
        seconds: duration in seconds; None if unknown.
        calls: number of requests to the model; None if unknown.
        tokens: number of input and output tokens; None if unknown.
        words: the agent's last words, or the last message about the episode, as evidence.
        unseen: kinds of objects in the goal that no observation names, if a replay shows the goal.
        unknown: names of properties that the log does not have.
        format: name of the form of the log. `read_log` adds it.
    """

    task: str
    outcome: EpisodeOutcome
    ending: EpisodeEndReason
    steps: tuple[LoggedStep, ...] = ()
    agent: str = ""
    setting: str = ""
    opening: str = ""
    actions: int | None = None
    progress: float | None = None
    seconds: float | None = None
    calls: int | None = None
    tokens: int | None = None
    words: str = ""
    unseen: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    format: str = ""

    @property
    def index_of_first_error(self) -> int | None:
        """Index of the first rejected action, from 0; None if the log shows no rejected action."""
        return next((number for number, step in enumerate(self.steps) if step.is_error), None)

    @property
    def best_goal_progress(self) -> float | None:
        """The largest share of goal conditions that held at once; None if no share is known."""
        shares = [step.progress for step in self.steps] + [self.progress]
        return max((share for share in shares if share is not None), default=None)

    @property
    def step_of_best_goal_progress(self) -> int | None:
        """Index of the first step, from 0, after which the largest share of goals held; None if not known."""
        shares = [step.progress for step in self.steps]
        if self.best_goal_progress is None or self.best_goal_progress not in shares:
            return None
        return shares.index(self.best_goal_progress)

    @property
    def max_occurrences_of_action_reply_pair(self) -> int | None:
        """How often the most frequent pair of action and reply occurs; None if there are no steps."""
        return max(Counter((step.action, step.feedback) for step in self.steps).values(), default=None)
