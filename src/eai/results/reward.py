"""Rewards: the worth of an answer to a training loop, and the reasons.

Shapings are functions of what a verdict says. All that an answer is worth lies between 0 and 1, and these
hold of every answer (``docs/training.md`` has the definitions, and what they keep a policy from learning):

    success <= goals <= progress        diagnosis <= progress        a success is paid as much as its progress
    success <= partial

Episodes are paid by the same definitions: a turn pays by how much it changes what its episode is worth.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial

from typing_extensions import assert_never

from eai.abilities.declaration import declaration_of
from eai.abilities.protocol import Ability
from eai.abilities.scorer import PlanScorer, exception_text
from eai.abilities.verdict import Credit, ErrorReport, PlanVerdict, Verdict, compute_condition_gain
from eai.base.errors import EaiError, InputError, find_member
from eai.benchmarks.names import TaskReference
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.tasks.source import Source
from eai.world.fault import FaultKind

_LOG = logging.getLogger(__name__)


class Shaping(str, Enum):
    """The merit that an answer is paid for."""

    SUCCESS = "success"
    """1 for an answer that is right as a whole, else 0; of subgoals divided as all that they earn."""
    GOALS = "goals"
    """The gain, if no error ended it; else 0."""
    PROGRESS = "progress"
    """The gain, up to the error that ended it if one did."""
    DIAGNOSIS = "diagnosis"
    """``progress`` divided by one more than the number of faults that were diagnosed."""
    REPAIR = "repair"
    """The nearness to success, of plans only: by how few edits they would succeed."""
    PARTIAL = "partial"
    """The gain in partial success, up to the error that ended the answer; for other answers ``progress``."""


def worth(earned: Credit, shaping: Shaping) -> float:
    """The pay of an answer, by all that is paid for but repairs: those need its steps.

    Raises:
        ValueError: it is to be paid by its repair.
    """
    match shaping:
        case Shaping.SUCCESS:
            by_itself = float(earned.success)
        case Shaping.GOALS:
            by_itself = 0.0 if earned.ended else earned.gain
        case Shaping.PROGRESS:
            by_itself = earned.gain
        case Shaping.DIAGNOSIS:
            by_itself = earned.gain / (1 + sum(earned.faults.values()))
        case Shaping.REPAIR:
            raise ValueError("how near a plan is to success is not told by its merits")
        case Shaping.PARTIAL:
            by_itself = earned.gain if earned.conditions is None else earned.conditions
        case _:
            assert_never(shaping)
    return by_itself / (1 + earned.added_actions)


def merit(verdict: Verdict, at_start: Sequence[bool] = ()) -> Credit | None:
    """The merit of an answer, or None where there is nothing to earn.

    Nothing is to be earned in a task that is in no statistics, that asks for nothing, or all of whose goals
    hold before anything is done.

    Args:
        verdict: the verdict on the answer.
        at_start: for each goal of the task, in order, whether it is reached where nothing is done.
    """
    return None if verdict.excluded is not None else verdict.credit(at_start)


METRICS = ("success", "progress", "faults", *(f"fault.{kind.value}" for kind in FaultKind))
"""The names of what is measured beside a reward, in order; the same for every ability."""


@dataclass(frozen=True, slots=True)
class Grade:
    """The reward of one answer, and why.

    Attributes:
        value: the reward, between 0 and 1; None where nothing is to be earned, whatever the answer.
        metrics: numbers to watch, which are not part of the reward, under the names of `METRICS`: ``success``
            (0 or 1), ``progress`` (0 to 1), ``faults`` and ``fault.KIND`` (how many, in all and of a kind of
            the paper's). All 0 where nothing is to be earned.
        verdict: the verdict.
    """

    value: float | None
    metrics: Mapping[str, float]
    verdict: Verdict


MAX_ANSWER_CHARACTERS = 10_000
"""How long answers are that are read, in characters; the longest of some 25,000 that we know has 9,651."""


def is_paid(ability: Ability) -> bool:
    """Whether the verdicts on answers of an ability say what these have earned."""
    return declaration_of(ability).verdict.credit is not Verdict.credit


class Reward:
    """The reward of a suite: a pure function of task and text, for one answer or many.

    It may be called from any number of threads, and is pickled as the suite is: by name. Operators are
    compared with the gold ones and never given to a planner, which takes seconds and which operators without
    preconditions satisfy.

    Args:
        suite: the tasks. Under another protocol than ``strict`` what is promised of rewards need not hold.
        shaping: what an answer is paid for: ``success``, ``goals``, ``progress``, ``diagnosis``, ``partial``
            or, of plans under ``strict``, ``repair``.
        limit: the longest answer that is read, in characters; what is longer is unreadable, so that no text
            takes long. Reasoning in it is set aside.

    Raises:
        InputError: there is no such shaping, it is of plans only and the suite is of something else, or the
            suite's verdicts do not say what an answer has earned.
    """

    def __init__(
        self, suite: Suite, shaping: Shaping | str = Shaping.SUCCESS, *, limit: int = MAX_ANSWER_CHARACTERS
    ) -> None:
        self.suite = _without_planner(suite)
        self.shaping = find_member(Shaping, shaping, "shaping")
        if self.shaping is Shaping.REPAIR and suite.ability is not Ability.ACTION_SEQUENCING:
            plans = Ability.ACTION_SEQUENCING.value
            raise InputError(f"the shaping repair is of {plans} only, not of {suite.ability.value}")
        if not is_paid(suite.ability):
            raise InputError(f"answers to {suite.ability.value} are not paid: its verdicts have no merit")
        self.limit = limit
        self._at_start = cache(self._reached_at_start)
        self._met_at_start = cache(self._partial_at_start)

    def __reduce__(self) -> tuple[Callable[..., Reward], tuple[Suite, Shaping]]:
        return partial(Reward, limit=self.limit), (self.suite, self.shaping)

    def __call__(self, task_id: str, text: str) -> float | None:
        """The reward of an answer, from 0 to 1; None where nothing is to be earned, whatever the answer.

        Raises:
            InputError: there is no such task.
        """
        return self._paid(task_id, text, self._merit(task_id, self._verdict(task_id, text)))

    def batch(self, task_ids: Sequence[str], texts: Sequence[str]) -> list[float | None]:
        """The reward of each answer, in order.

        Raises:
            InputError: there is no such task.
            ValueError: there are more of the one than of the other.
        """
        return [self(task_id, text) for task_id, text in zip(task_ids, texts, strict=True)]

    def grade(self, task_id: str, text: str) -> Grade:
        """The reward of an answer, with metrics and verdict.

        Raises:
            InputError: there is no such task.
        """
        verdict = self._verdict(task_id, text)
        earned = self._merit(task_id, verdict)
        return Grade(self._paid(task_id, text, earned), metrics_of(earned), verdict)

    def _paid(self, task_id: str, text: str, earned: Credit | None) -> float | None:
        """The reward of an answer with these merits."""
        if earned is None or self.shaping is not Shaping.REPAIR:
            return None if earned is None else worth(earned, self.shaping)
        scorer = self.suite.scorer(task_id)
        if not isinstance(scorer, PlanScorer):
            raise InputError(f"the shaping repair is not known under {self.suite.protocol.value}")
        try:
            return scorer.closeness(text if len(text) <= self.limit else "")
        except EaiError:
            raise
        except Exception as error:
            _LOG.warning("an answer to %s earns nothing: %s", task_id, exception_text(error))
            return 0.0

    def _verdict(self, task_id: str, text: str) -> Verdict:
        if len(text) <= self.limit:
            return self.suite.score(task_id, text)
        too_long = ErrorReport(FaultKind.PARSING, None, f"it is longer than {self.limit:,} characters")
        return replace(self.suite.score(task_id, ""), error=too_long)

    def _merit(self, task_id: str, verdict: Verdict) -> Credit | None:
        if not self.suite.has_plans:
            return merit(verdict)
        earned = merit(verdict, self._at_start(task_id))
        if earned is None or not isinstance(verdict, PlanVerdict) or verdict.declines:
            return earned
        if self.suite.tasks[task_id].has_no_plan:
            return replace(earned, gain=0.0, success=False)
        if self.shaping is not Shaping.PARTIAL or verdict.partial is None:
            return earned
        gained = compute_condition_gain(verdict.partial, self._met_at_start(task_id), earned.gain)
        return replace(earned, conditions=gained)

    def _reached_at_start(self, task_id: str) -> tuple[bool, ...]:
        """For each goal, in order, whether it is reached where nothing is done."""
        task = self.suite.tasks[task_id]
        return GoalTest(task).reached(task.initial, ())

    def _partial_at_start(self, task_id: str) -> Share:
        """The partial success of a plan without steps."""
        task = self.suite.tasks[task_id]
        return GoalTest(task).partial(task.initial, (), self._at_start(task_id))


def reward(task: str, text: str, shaping: Shaping | str = Shaping.SUCCESS) -> float | None:
    """The reward of an answer, from 0 to 1; None where nothing is to be earned, whatever the answer.

    Suites are opened at first use and kept, so that this may be called for every answer of a training run.

    Args:
        task: benchmark, ability and id, as ``lamps:lamps/action_sequencing/light``; see `Suite.reference`.
        text: the answer.
        shaping: what it is paid for, as `Reward` has it.

    Raises:
        InputError: there is no such task or shaping.
        DataError: the data cannot be had.
    """
    found = TaskReference.parse(task)
    return open_reward(found, shaping)(found.task_id, text)


def open_reward(task: TaskReference, shaping: Shaping | str) -> Reward:
    """The reward of the suite that a task is of, opened once.

    Raises:
        InputError: there is no such suite or shaping.
        DataError: the data cannot be had.
    """
    return _opened(task.benchmark, task.ability, find_member(Shaping, shaping, "shaping"))


@cache
def open_reward_suite(benchmark: str, ability: Ability) -> Suite:
    """A suite that answers are paid in, opened once and without a planner; as `TaskReference` names it.

    Raises:
        InputError: there is no such suite.
        DataError: the data cannot be had.
    """
    return open_suite(benchmark, ability, source=Source(planner=PlannerChoice.NONE))


@cache
def _opened(benchmark: str, ability: Ability, shaping: Shaping) -> Reward:
    return Reward(open_reward_suite(benchmark, ability), shaping)


def _without_planner(suite: Suite) -> Suite:
    """The suite opened so that no planner judges operators."""
    planned = suite.ability is Ability.TRANSITION_MODELING and suite.source.planner is not PlannerChoice.NONE
    return suite.reopen(source=replace(suite.source, planner=PlannerChoice.NONE)) if planned else suite


def metrics_of(earned: Credit | None) -> dict[str, float]:
    """The metrics of a grade; None stands for a task in which nothing is to be earned."""
    if earned is None:
        return dict.fromkeys(METRICS, 0.0)
    faults = {f"fault.{kind.value}": float(earned.faults.get(kind, 0)) for kind in FaultKind}
    return {
        "success": float(earned.success),
        "progress": earned.gain,
        "faults": sum(faults.values()),
        **faults,
    }
