"""Define the rules of a game: execution of actions, observations, end and rewards."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import Field, model_validator
from typing_extensions import Self

from eai.abilities.experiment import MAX_BUDGET, MAX_STEPS
from eai.abilities.replanning_options import EndCondition
from eai.base.errors import InputError
from eai.results.reward import Shaping
from eai.tasks.options import Options
from eai.tasks.prompts.prompt import PromptSet

View: TypeAlias = Literal["task", "scene"]
"""The objects in observations: the objects of the task, or all objects of the scene.

The list of a task's objects is a hint: it shows which objects the task needs. A prompt that asks for a whole
plan gives this hint, too. With ``scene``, relations that a domain declares as `egocentric` are shown only for
the agent.
"""

Observe: TypeAlias = Literal["full", "partial"]
"""How many objects of the view (`View`) an agent observes: all, or only objects visible from its place."""

Feedback: TypeAlias = Literal["facts", "changes", "outcome", "pictures"]
"""The observation after a turn: all visible facts, the changes, or only the outcome of the action.

The first observation lists all facts, so an agent with ``changes`` can keep track of them. With ``pictures``
no facts are listed; rendered pictures show them at first and after each turn.
"""

OUTCOMES: tuple[Feedback, ...] = ("outcome", "pictures")
"""Values of the rule ``feedback`` with which texts list no facts, only whether the action worked."""


class GameRules(Options):
    """The rules of a game: options of `eai.agents.gym.make`, and of the packages that play games.

    Raises:
        InputError: a partial view is combined with feedback of outcomes only.

    Attributes:
        slip: The probability that a possible action does not work.
        view: The objects in observations: task (objects of the task, a hint that prompts give too), or scene
            (all objects).
        observe: How much of the world is shown: full, or partial (only objects that the agent can see, by the
            domain's definition). In a partial view, actions may name only objects that have been seen.
        reward: The definition of the reward: success, goals, progress, diagnosis, repair or partial, as by
            eai.Reward. The reward of a turn is the change in the value of the episode.
        gamma: The discount. The reward of a turn is the discounted value of the episode after it, minus the
            value before.
        until: When an episode ends: goal (in the first state in which all goals are reached), or done (when
            the agent writes DONE).
        max_steps: Number of actions after which an episode is cut off; None for no limit.
        budget: The maximum number of actions: this number times the length of the shortest known plan, plus
            8, but at least as many as the commands that are known to win. None for no such limit.
        admissible: List all possible actions about objects that have been seen.
        feedback: The text after each turn: facts (all visible facts), changes, outcome (of the action only),
            or pictures (the outcome only, and no facts even at first, because pictures show them). In a
            partial view, changes include objects that come into sight, with their facts, and objects that go
            out of sight.
        prompts: The set of prompts of the texts about the world and the task, such as short or facts.
        verifier: Whether the agent may ask the verifier. Such runs are never ranked with others.
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
    prompts: PromptSet = "eai"
    verifier: bool = False

    @property
    def rules_for_episode_replay(self) -> GameRules:
        """Rules for replays, which need no rewards at each turn and no lists of possible actions."""
        unpaid = {"reward": Shaping.SUCCESS, "gamma": 1.0, "admissible": False}
        return self.model_copy(update=unpaid)

    @model_validator(mode="after")
    def _require_feedback_with_facts_in_partial_view(self) -> Self:
        if self.observe == "partial" and self.feedback in OUTCOMES:
            raise InputError(
                "observe=partial needs feedback=facts or feedback=changes, because other feedback "
                "does not list what the agent sees"
            )
        return self


STANDARD = GameRules(
    view="scene", observe="partial", until="done", feedback="changes", max_steps=None, budget=2.0
)
"""Standard rules of acting.

The agent sees only objects that are visible from its place. It wins if it sends `DONE` when all goals are
reached, before the limit of actions.
"""

TRAINING = GameRules(max_steps=50)
"""Default rules of episodes in which a model is trained by rewards."""
