"""The verdict on a sequence of subgoals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from typing_extensions import Self

from eai.abilities.verdict import Credit, PlanVerdict
from eai.world.fault import FaultKind


class SubgoalCategory(str, Enum):
    """The outcomes of subgoal decomposition (reference: ``subgoal_eval_utils.py``)."""

    CORRECT = "correct"
    RUNTIME = "runtime"
    GOAL_UNREACHABLE = "goal_unreachable"
    HALLUCINATION = "hallucination"
    NOT_PARSEABLE = "not_parseable"


@dataclass(frozen=True, slots=True)
class SubgoalVerdict(PlanVerdict):
    """The verdict on a sequence of subgoals.

    Attributes:
        category: the outcome.
        goals_elsewhere: whether the goals are those of another way to carry the subgoals out than the
            reported one, which reaches fewer.
        errors: the kinds of all errors of the reported way to carry them out, in order.
        offences: what is wrong with names, each kind once.
        search: why the search for a way ended, or None if there was none.
        tried_actions: number of actions that the search tried.
        refined: for how many subgoals actions were executed, on the reported way.
        added_actions: how many more actions than one for each of them.
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
        """All errors of the way that is reported, or else those of any plan."""
        return Counter(self.errors) or PlanVerdict.faults(self)

    def credit(self, at_start: Sequence[bool]) -> Credit | None:
        """As of any plan, with what the search added."""
        earned = PlanVerdict.credit(self, at_start)
        return None if earned is None else replace(earned, added_actions=self.added_actions or 0)

    def as_missing_answer(self) -> Self:
        """As of any plan; there is no outcome."""
        unanswered = PlanVerdict.as_missing_answer(self)
        return unanswered if self.excluded is not None else replace(unanswered, category=None)
