"""The rules of a game: how actions are carried out, what is seen, when it ends and what it pays for."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from eai.errors import InputError
from eai.scoring.shaping import Shaping
from eai.world.episode import Slips, Until


class Observe(str, Enum):
    """How much of the world an observation shows: all that the task is about, or what the agent can see."""

    FULL = "full"
    PARTIAL = "partial"


class Feedback(str, Enum):
    """What is told of a turn: all that is seen to be so, what the action changed, or what became of it alone.

    The opening lists all facts in any case, so that with ``changes`` they are known to who keeps count.
    """

    FACTS = "facts"
    CHANGES = "changes"
    OUTCOME = "outcome"


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of a game.

    Attributes:
        slip: the probability that a possible action does not work.
        observe: how much of the world is shown.
        reward: what is paid for, by the definition of `eai.Reward`; a turn pays by how much it changes what
            the episode is worth.
        gamma: the discount: a turn pays this share of what the episode is worth after it, less all of before.
        until: when an episode ends.
        max_steps: after how many actions it is cut off; None for never.
        admissible: whether all actions that are possible now are listed after each turn.
        feedback: what is told of each turn; in a partial view the facts.

    Raises:
        InputError: a number is out of its range, or a partial view is to be told otherwise than by facts.
    """

    slip: float = 0.0
    observe: Observe = Observe.FULL
    reward: Shaping = Shaping.SUCCESS
    gamma: float = 1.0
    until: Until = Until.GOAL
    max_steps: int | None = 100
    admissible: bool = False
    feedback: Feedback = Feedback.FACTS

    def __post_init__(self) -> None:
        Slips(self.slip)
        if not 0 <= self.gamma <= 1:
            raise InputError(f"a discount of {self.gamma} is not between 0 and 1")
        if self.max_steps is not None and self.max_steps < 1:
            raise InputError(f"an episode of at most {self.max_steps} steps has none")
        if self.observe is Observe.PARTIAL and self.feedback is not Feedback.FACTS:
            raise InputError(f"a partial view is told by its facts, not by {self.feedback.value}")
