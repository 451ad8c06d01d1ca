"""The rules of a game: how actions are carried out, what is seen, when it ends and what it pays."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from typing_extensions import assert_never

from eai.errors import InputError
from eai.scoring.shaping import gain
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


class Reward(str, Enum):
    """What is paid, by the gain of `eai.Reward`: a goal that holds at the start earns nothing.

    ``sparse`` is the paper's (appendix on the decision process): 1 at the end if all goals are reached, else
    0. ``progress`` is the change of a potential, the gain: what it adds up to depends on where an episode
    ends alone (Ng, Harada and Russell 1999). ``verdict`` is paid at the end too: what the actions are worth
    as one plan, that is, the gain, and 0 if any of them could not be carried out.
    """

    SPARSE = "sparse"
    PROGRESS = "progress"
    VERDICT = "verdict"


class Standing(NamedTuple):
    """Which goals of a task are reached, in order, and which were at the start."""

    reached: tuple[bool, ...]
    at_start: tuple[bool, ...]

    @property
    def complete(self) -> bool:
        """Whether all are."""
        return all(self.reached)

    @property
    def gain(self) -> float:
        """What is gained: the potential of a state; 0 where there is nothing to gain."""
        return gain(self.reached, self.at_start) or 0.0


@dataclass(frozen=True, slots=True)
class Rules:
    """The rules of a game.

    Attributes:
        slip: the probability that a possible action does not work.
        observe: how much of the world is shown.
        reward: what is paid.
        gamma: the discount that ``progress`` reckons with.
        until: when an episode ends.
        max_steps: after how many actions it is cut off; None for never.
        admissible: whether all actions that are possible now are listed after each turn.
        feedback: what is told of each turn; in a partial view the facts.

    Raises:
        InputError: a number is out of its range, or a partial view is to be told otherwise than by facts.
    """

    slip: float = 0.0
    observe: Observe = Observe.FULL
    reward: Reward = Reward.SPARSE
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

    def pay(self, before: Standing, after: Standing, *, ended: bool, executable: bool) -> float:
        """The reward of one turn.

        Args:
            before: how the goals stood before it.
            after: how they stand after it.
            ended: whether the episode is over.
            executable: whether every action so far could be carried out, needless ones aside.
        """
        match self.reward:
            case Reward.SPARSE:
                return float(ended and after.gain == 1)
            case Reward.PROGRESS:
                return self.gamma * after.gain - before.gain
            case Reward.VERDICT:
                return after.gain if ended and executable else 0.0
            case _:
                assert_never(self.reward)
