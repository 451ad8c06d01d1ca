"""The verdict on a sequence of subgoals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from typing_extensions import Self

from eai.abilities.verdict import PlanVerdict, RewardInputs
from eai.world.fault import FaultKind


class SubgoalCategory(str, Enum):
    """The possible outcomes of subgoal decomposition (``subgoal_eval_utils.py`` in the paper's package)."""

    CORRECT = "correct"
    RUNTIME = "runtime"
    GOAL_UNREACHABLE = "goal_unreachable"
    HALLUCINATION = "hallucination"
    NOT_PARSEABLE = "not_parseable"


@dataclass(frozen=True, slots=True)
class SubgoalVerdict(PlanVerdict):
    """The verdict on a sequence of subgoals.

    Attributes:
        category: the outcome of the answer.
        goals_elsewhere: whether the verdict counts the goals of another way to execute the subgoals than the
            reported way, which reaches fewer goals.
        errors: kinds of all errors in the reported way to execute the subgoals, in order.
        offences: kinds of misused names, each once.
        search: why the search ended; None if there was no search.
        tried_actions: number of actions that the search tried.
        refined: number of subgoals for which actions were executed in the reported way.
        added_actions: number of actions that the search added: executed actions minus ``refined``.
    """

    category: SubgoalCategory | None = None
    goals_elsewhere: bool = False
    errors: tuple[FaultKind, ...] = ()
    offences: tuple[str, ...] = ()
    search: str | None = None
    tried_actions: int | None = None
    refined: int | None = None
    added_actions: int | None = None

    def faults(self) -> Mapping[FaultKind, int]:
        """Return the number of faults by kind.

        Errors in the reported execution of the answer count. If this execution has no errors, the error of
        the verdict and additional steps count.
        """
        return Counter(self.errors) or PlanVerdict.faults(self)

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the credit for the executed subgoals, or None if all goals hold at the start.

        The credit records how many actions the scorer added to reach subgoals.
        """
        earned = PlanVerdict.compute_reward_inputs(self, goals_at_start)
        return None if earned is None else replace(earned, added_actions=self.added_actions or 0)

    def to_verdict_on_missing_answer(self) -> Self:
        """Return this verdict changed for a missing answer: no goal is reached, and `category` is None."""
        unanswered = PlanVerdict.to_verdict_on_missing_answer(self)
        return unanswered if self.excluded is not None else replace(unanswered, category=None)
