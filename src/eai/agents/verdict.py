"""The verdict on an episode of the ability ``acting``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from eai.abilities.declining import is_clarification_question
from eai.abilities.verdict import UNREPLAYABLE, PlanVerdict, Verdict
from eai.tasks.share import Share
from eai.world.fault import FaultKind

Recoverability: TypeAlias = Literal["open", "lost", "unknown"]
"""Whether the goals can still be reached after an episode: yes, no, or unknown if the search ended early."""


@dataclass(frozen=True, slots=True)
class EpisodeTurn:
    """One turn of an episode.

    Attributes:
        said: the command.
        told_sha256: SHA-256 digest of the observation after the command.
        is_action: whether an action was tried. False for the command to look, for the command that ends the
            episode, and after the limit of actions.
        fault: the kind of error of the action; None without an error.
        slipped: whether the action was possible but, by chance, had no effect.
        goals: a text with a digit for each goal of the task: 1 if the goal is reached after the turn, else 0.
        same_as: number of the first turn, from 1 on, after which the world was in this state; 0 for the
            start, None for a new state.
    """

    said: str
    told_sha256: str
    is_action: bool
    fault: FaultKind | None
    slipped: bool
    goals: str
    same_as: int | None


@dataclass(frozen=True, slots=True)
class EpisodeVerdict(PlanVerdict):
    """The verdict on an episode. The field ``executable`` says that no action was impossible.

    Attributes:
        turns: the commands, and the outcome of each command.
        ended: why the episode ended: ``done`` (the agent said so), ``goal`` (all goals were reached),
            ``refused`` (the agent called the task impossible), a limit of ``steps``, ``tokens``, ``time`` or
            ``turns`` (replies of the model), or ``stopped`` (by the agent).
        declared: whether the agent said that the task is done.
        reached: whether all goals hold at the end, also if the agent has not said so.
        shortest: number of actions of the shortest known plan; None if no plan is known.
        budget: maximum number of actions.
        view: the objects that the agent can see, and whether it sees all of them or only from its place.
        harness: the program that let the model act; empty if unknown.
        without_call: the beginning of the first reply that called no tool; None if each reply called a tool.
        begun: how often the episode was started; the last start counts.
        outlook: whether the goals can still be reached at the end; None if no planner checked this.
        lost_at: the first turn, from 1 on, after which the goals cannot be reached; 0 if never reachable.
        mean: the mean contributions to rates of all episodes of the task, if this verdict represents them
            all.
    """

    turns: tuple[EpisodeTurn, ...] = ()
    ended: str = "stopped"
    declared: bool = False
    reached: bool = False
    shortest: int | None = None
    budget: int | None = None
    view: str = ""
    harness: str = ""
    begun: int = 1
    without_call: str | None = None
    outlook: Recoverability | None = None
    lost_at: int | None = None
    mean: Mapping[str, Share] | None = None

    compute_reward_inputs = Verdict.compute_reward_inputs
    """Raises NotImplementedError: a stored episode earns no reward, as its player chose the game rules."""

    def find_contradiction(self) -> str | None:
        """Return a sentence on contradictory fields of a won episode, or None.

        Lost episodes are not checked, because all goals may hold in an episode that is lost without ``DONE``.
        """
        return PlanVerdict.find_contradiction(self) if self.success else None

    @property
    def is_unreplayable(self) -> bool:
        """Whether a replay of the commands gave observations that differ from those in the episode."""
        return self.error is not None and self.error.check == UNREPLAYABLE

    @property
    def action_turns(self) -> tuple[EpisodeTurn, ...]:
        """The turns in which an action was tried."""
        return tuple([turn for turn in self.turns if turn.is_action])

    @property
    def is_task_declined_by_answer(self) -> bool:
        """Whether the agent has called the task impossible, or asked a question that the task allows."""
        asked = (turn for turn in self.action_turns if is_clarification_question(turn.said))
        return self.refused is not None or any(turn.fault is None for turn in asked)

    def is_step_an_action(self, step_index: int) -> bool:
        """Whether the turn with this index tried an action. No turn after the limit of actions does."""
        return self.turns[step_index].is_action


def describe_goal_reachability(verdict: EpisodeVerdict) -> str:
    """Return a sentence on whether the goals can still be reached at the end of an episode."""
    if verdict.outlook == "lost":
        after = f"after turn {verdict.lost_at}" if verdict.lost_at else "from the start"
        return f"lost for good {after}: no actions lead to the goals any more"
    if verdict.outlook == "open":
        return "not lost for good: at the end the goals could still be reached"
    return "whether the goals could still be reached at the end is not known"
