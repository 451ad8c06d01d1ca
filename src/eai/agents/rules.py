"""The rules of a game: how actions are carried out, what is seen, when it ends and what it pays for."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import Field, model_validator
from typing_extensions import Self

from eai.abilities.attempt_options import EndCondition
from eai.abilities.experiment import MAX_BUDGET, MAX_STEPS
from eai.base.errors import InputError
from eai.results.reward import Shaping
from eai.tasks.options import Options

View: TypeAlias = Literal["task", "scene"]
"""The objects that an observation is about: those of the task, or all of the scene.

Which objects a task is about is a hint, which prompts give too. In the view of the scene, relations that a
domain declares as `egocentric` are shown of the agent alone.
"""

Observe: TypeAlias = Literal["full", "partial"]
"""How much of these objects an observation shows: all, or what the agent can see."""

Feedback: TypeAlias = Literal["facts", "changes", "outcome", "pictures"]
"""The observation after a turn: all visible facts, the changes, or the outcome of the action alone.

The opening lists all facts, so that with ``changes`` they are known to who keeps count; but with ``pictures``
it lists none: what holds is in rendered pictures, then and after each turn.
"""

OUTCOMES: tuple[Feedback, ...] = ("outcome", "pictures")
"""The ways in which a turn tells the outcome of the action alone."""


class Rules(Options):
    """The rules of a game: options of `eai.agents.gym.make`, and of the packages that play games.

    Raises:
        InputError: a partial view is to be told the outcome of actions alone.

    Attributes:
        slip: The probability that a possible action does not work.
        view: Which objects observations are about: task (those that the task is about, a hint that prompts
            give too), or scene (all).
        observe: How much of the world is shown: full, or partial: what the agent can see, as the domain
            declares it. Then actions may name only what has been seen.
        reward: What is paid for: success, goals, progress, diagnosis, repair or partial, as by eai.Reward. A
            turn pays by how much it changes what the episode is worth.
        gamma: The discount: a turn pays this share of what the episode is worth after it, less all of before.
        until: When an episode ends: goal (in the first state in which all goals are reached), or done (when
            the agent writes DONE, as a plan ends).
        max_steps: After how many actions an episode is cut off; None for never.
        budget: Cut an episode off after this many times the shortest plan known and 8 actions more, or after
            the actions of the reference if these are more; None for no such limit.
        admissible: List all actions that are possible now, about what has been seen.
        feedback: What is told of each turn: all facts that are seen, changes alone, the outcome of the action
            alone, or this and no facts even at first, for those who are shown pictures. In a partial view
            changes say also what comes into sight, with its facts, and what goes.
    """

    slip: float = Field(default=0.0, ge=0, le=1)
    view: View = "task"
    observe: Observe = "full"
    reward: Shaping = Shaping.SUCCESS
    gamma: float = Field(default=1.0, ge=0, le=1)
    until: EndCondition = "goal"
    max_steps: int | None = Field(default=100, ge=1, le=MAX_STEPS)
    budget: float | None = Field(default=None, ge=0, le=MAX_BUDGET)
    admissible: bool = False
    feedback: Feedback = "facts"

    @property
    def of_replay(self) -> Rules:
        """The rules without the rewards and the lists of possible actions, which only a player needs."""
        unpaid = {"reward": Shaping.SUCCESS, "gamma": 1.0, "admissible": False}
        return self.model_copy(update=unpaid)

    @model_validator(mode="after")
    def _without_contradictions(self) -> Self:
        if self.observe == "partial" and self.feedback in OUTCOMES:
            raise InputError("a partial view is told by its facts or changes, not by the outcome alone")
        return self


STANDARD = Rules(
    view="scene", observe="partial", until="done", feedback="changes", max_steps=None, budget=2.0
)
"""The standard setting of acting: the scene is seen from where one is, and won only by `DONE` in time."""

TRAINING = Rules(max_steps=50)
"""The default rules of trainers."""
