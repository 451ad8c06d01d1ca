"""The verdict on a sequence of subgoals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from typing_extensions import Self

from eai.abilities.verdict import PlanVerdict, RewardInputs
from eai.world.fault import FaultKind


class SubgoalAnswerCategory(str, Enum):
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
        goals_elsewhere: whether the counted goals are not those of the reported execution. The search
            executes the subgoals in several ways, and the way that reaches most goals counts.
        errors: kinds of all errors in the reported execution of the subgoals, in order.
        offences: kinds of misused names, each once.
        search: why the search ended; None if there was no search.
        tried_actions: number of actions that the search tried.
        refined: number of subgoals for which actions were executed in the reported execution.
        added_actions: number of actions that the search added: executed actions minus ``refined``.
        errors_elsewhere: kinds of all errors in the other execution, in order; empty unless
            ``goals_elsewhere``.
        added_elsewhere: number of actions that the search added in the other execution; None unless
            ``goals_elsewhere``.
    """

    category: SubgoalAnswerCategory | None = None
    goals_elsewhere: bool = False
    errors: tuple[FaultKind, ...] = ()
    offences: tuple[str, ...] = ()
    search: str | None = None
    tried_actions: int | None = None
    refined: int | None = None
    added_actions: int | None = None
    errors_elsewhere: tuple[FaultKind, ...] = ()
    added_elsewhere: int | None = None

    def count_faults_by_kind(self) -> Mapping[FaultKind, int]:
        """Return the number of faults by kind.

        The faults are the items of `errors`. If `errors` is empty, the faults are those of `PlanVerdict`:
        `error` and `additional_steps`.
        """
        return Counter(self.errors) or PlanVerdict.count_faults_by_kind(self)

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the inputs of the reward for the executed subgoals, or None if all goals hold at the start.

        One input is the number of actions that the search added to reach subgoals. If the goals of another
        execution count (`goals_elsewhere`), the errors and the added actions of that execution count, too.
        """
        earned = PlanVerdict.compute_reward_inputs(self, goals_at_start)
        if earned is None:
            return None
        if self.added_elsewhere is None:
            return replace(earned, added_actions=self.added_actions or 0)
        errors = Counter(self.errors_elsewhere)
        ended = any(kind is not FaultKind.ADDITIONAL_STEP for kind in errors)
        return replace(earned, ended=ended, faults=errors, added_actions=self.added_elsewhere)

    def to_verdict_on_missing_answer(self) -> Self:
        """Return this verdict changed for a missing answer: no goal is reached, and `category` is None."""
        unanswered = PlanVerdict.to_verdict_on_missing_answer(self)
        return unanswered if self.excluded is not None else replace(unanswered, category=None)
