"""Rewards of answers for training, with the metrics that explain them.

A shaping is a rule that turns the verdict on an answer into its reward, from 0 to 1. ``docs/training.md`` has
the definitions, and what they prevent a policy from learning. For every answer, the rewards by the members of
`Shaping` satisfy three rules:

- success <= goals <= progress
- success <= partial
- diagnosis <= progress

A right answer has the same reward by success and by progress.

Episodes are paid by the same definitions: the reward of a turn is the change of the episode's value.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence, Sized
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache, partial

from typing_extensions import assert_never

from eai.abilities.declaration import get_declaration
from eai.abilities.protocol import Ability
from eai.abilities.scorer import PlanScorer, describe_exception
from eai.abilities.verdict import ErrorReport, PlanVerdict, RewardInputs, Verdict, compute_condition_gain
from eai.base.errors import EaiError, InputError, find_enum_member
from eai.benchmarks.names import TaskReference
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.tasks.goal_test import GoalTest
from eai.tasks.share import Share
from eai.tasks.source import Source
from eai.world.fault import FaultKind

_LOG = logging.getLogger(__name__)


class Shaping(str, Enum):
    """A rule that turns the verdict on an answer into a reward."""

    SUCCESS = "success"
    """The reward is 1 if the whole answer is right, else 0.

    In subgoal decomposition, the rewards of all rules (`Shaping`) are divided by 1 plus the number of actions
    that scoring added to the answer to reach its subgoals.
    """
    GOALS = "goals"
    """The share of goals that the answer reaches, or 0 if an error stops its execution.

    Goals that held at the start do not count.
    """
    PROGRESS = "progress"
    """The share of the goals that the answer reaches before an error stops its execution.

    Goals that held at the start do not count.
    """
    DIAGNOSIS = "diagnosis"
    """The reward of ``progress``, divided by 1 plus the number of diagnosed faults."""
    REPAIR = "repair"
    """A reward that falls with the number of edits that a plan needs to succeed."""
    PARTIAL = "partial"
    """The gain in partial success up to the error that ended the answer.

    Partial success is the share of goal conditions that a plan meets. In abilities without partial success,
    the reward equals the reward of ``progress``.
    """


def compute_reward_from_inputs(inputs: RewardInputs, shaping: Shaping) -> float:
    """Return the reward for an answer.

    Args:
        inputs: the results of the answer, such as goals reached and errors.
        shaping: the definition of the reward. `Shaping.REPAIR` needs the plan's steps and is not possible.

    Raises:
        ValueError: the shaping is `REPAIR`.
    """
    match shaping:
        case Shaping.SUCCESS:
            pay = float(inputs.success)
        case Shaping.GOALS:
            pay = 0.0 if inputs.ended else inputs.gain
        case Shaping.PROGRESS:
            pay = inputs.gain
        case Shaping.DIAGNOSIS:
            pay = inputs.gain / (1 + sum(inputs.faults.values()))
        case Shaping.REPAIR:
            raise ValueError(
                "the reward `repair` cannot be computed from a verdict alone; use "
                "`eai.Reward(suite, 'repair')`"
            )
        case Shaping.PARTIAL:
            pay = inputs.gain if inputs.conditions is None else inputs.conditions
        case _:
            assert_never(shaping)
    return pay / (1 + inputs.added_actions)


def compute_reward_inputs_of_verdict(
    verdict: Verdict, reached_at_start: Sequence[bool] = ()
) -> RewardInputs | None:
    """Return the results of an answer that rewards depend on, or None if its task gives no reward.

    A task gives no reward if it is excluded from statistics, has no goals, or has only goals that hold at the
    start.

    Args:
        verdict: the verdict on the answer.
        reached_at_start: for each goal of the task, in order, whether it is reached without any action.
    """
    return None if verdict.excluded is not None else verdict.compute_reward_inputs(reached_at_start)


METRICS = ("success", "progress", "faults", *(f"fault.{kind.value}" for kind in FaultKind))
"""Names of the metrics in a `Grade`, in order; the same for every ability."""


@dataclass(frozen=True, slots=True)
class Grade:
    """The reward of one answer, with metrics and the verdict that explain it.

    Attributes:
        value: the reward, between 0 and 1; None if the task has no reward (it is excluded, or nothing can
            be gained).
        metrics: numbers to watch, which are not part of the reward, by the names of `METRICS`: ``success`` (0
            or 1), ``progress`` (0 to 1), ``faults`` and ``fault.KIND`` (number of faults, in all and of a
            kind of the paper). All are 0 if the task has no reward.
        verdict: the verdict.
    """

    value: float | None
    metrics: Mapping[str, float]
    verdict: Verdict


MAX_ANSWER_CHARACTERS = 10_000
"""Maximum length of an answer that is read, in characters; the longest of 25,000 public answers has 9,651."""


def can_earn_reward(ability: Ability) -> bool:
    """Whether answers of an ability can earn a reward: its verdicts override `compute_reward_inputs`."""
    return get_declaration(ability).verdict.compute_reward_inputs is not Verdict.compute_reward_inputs


def require_equal_lengths(**values: Sized) -> None:
    """Check that the arguments of a batch have a value for each answer.

    Raises:
        ValueError: the lengths differ; the message has the length of each argument.
    """
    if len(set(map(len, values.values()))) > 1:
        lengths = ", ".join(f"{len(value)} {name}" for name, value in values.items())
        raise ValueError(f"expected lists with one item for each answer, so of equal length; found {lengths}")


class Reward:
    """Reward function of a suite, the tasks of one ability in a benchmark.

    It depends only on the task and the text of the answer. It may be called from any number of threads. It
    can be pickled, because its suite is pickled by name. Operators are compared with the gold operators and
    never given to a planner. A planner takes seconds, and it would accept operators without preconditions.

    Args:
        suite: the tasks. Under scoring rules other than ``strict``, rewards can break the inequalities in the
            docstring of this module.
        shaping: definition of the reward: ``success``, ``goals``, ``progress``, ``diagnosis``, ``partial``,
            or ``repair`` for plans under ``strict``.
        limit: maximum length of an answer that is read, in characters, so that no answer takes long. Longer
            answers are unreadable. Reasoning counts for the length, and is then ignored.

    Raises:
        InputError: the shaping does not exist or does not fit the suite, or answers to its ability have
            no reward.
    """

    def __init__(
        self, suite: Suite, shaping: Shaping | str = Shaping.SUCCESS, *, limit: int = MAX_ANSWER_CHARACTERS
    ) -> None:
        self.suite = _drop_planner_that_tests_operators(suite)
        self.shaping = find_enum_member(Shaping, shaping, "shaping")
        if self.shaping is Shaping.REPAIR and suite.ability is not Ability.ACTION_SEQUENCING:
            plans = Ability.ACTION_SEQUENCING.value
            raise InputError(
                f"shaping repair: expected {plans}, found {suite.ability.value}; choose another shaping"
            )
        if not can_earn_reward(suite.ability):
            raise InputError(f"answers to {suite.ability.value} have no reward; choose another ability")
        self.limit = limit
        self._at_start = cache(self._find_which_goals_hold_at_start)
        self._met_at_start = cache(self._find_partial_success_at_start)

    def __reduce__(self) -> tuple[Callable[..., Reward], tuple[Suite, Shaping]]:
        return partial(Reward, limit=self.limit), (self.suite, self.shaping)

    def __call__(self, task_id: str, text: str) -> float | None:
        """Return the reward of an answer, from 0 to 1; None if the task has no reward (`Grade.value`).

        Raises:
            InputError: the task id is unknown.
        """
        return self._compute_reward(
            task_id,
            text,
            self._compute_reward_inputs_of_answer(task_id, self._score_unless_too_long(task_id, text)),
        )

    def batch(self, task_ids: Sequence[str], texts: Sequence[str]) -> list[float | None]:
        """Return the reward of each answer, in order; None for each task without a reward (`Grade.value`).

        Raises:
            InputError: a task id is unknown.
            ValueError: the numbers of ids and texts differ.
        """
        require_equal_lengths(task_ids=task_ids, texts=texts)
        return [self(task_id, text) for task_id, text in zip(task_ids, texts, strict=True)]

    def grade(self, task_id: str, text: str) -> Grade:
        """Return the reward of an answer with metrics and verdict.

        Raises:
            InputError: the task id is unknown.
        """
        verdict = self._score_unless_too_long(task_id, text)
        inputs = self._compute_reward_inputs_of_answer(task_id, verdict)
        return Grade(
            self._compute_reward(task_id, text, inputs), make_metrics_from_reward_inputs(inputs), verdict
        )

    def _compute_reward(self, task_id: str, text: str, inputs: RewardInputs | None) -> float | None:
        if inputs is None or self.shaping is not Shaping.REPAIR:
            return None if inputs is None else compute_reward_from_inputs(inputs, self.shaping)
        scorer = self.suite.scorer(task_id)
        if not isinstance(scorer, PlanScorer):
            raise InputError(
                "the reward shaping by repair is only defined for the protocol strict, not for "
                f"{self.suite.protocol.value}: choose strict"
            )
        try:
            return scorer.compute_closeness_to_success(text if len(text) <= self.limit else "")
        except EaiError:
            raise
        except Exception as error:
            _LOG.warning("an answer to %s earns nothing: %s", task_id, describe_exception(error))
            return 0.0

    def _score_unless_too_long(self, task_id: str, text: str) -> Verdict:
        if not isinstance(text, str) or len(text) <= self.limit:
            return self.suite.score(task_id, text)
        too_long = ErrorReport(FaultKind.PARSING, None, f"it is longer than {self.limit:,} characters")
        return replace(self.suite.score(task_id, ""), error=too_long)

    def _compute_reward_inputs_of_answer(self, task_id: str, verdict: Verdict) -> RewardInputs | None:
        if not self.suite.answers_are_plans:
            return compute_reward_inputs_of_verdict(verdict)
        inputs = compute_reward_inputs_of_verdict(verdict, self._at_start(task_id))
        if inputs is None or not isinstance(verdict, PlanVerdict) or verdict.is_task_declined_by_answer:
            return inputs
        if self.suite.tasks[task_id].has_no_plan:
            return replace(inputs, gain=0.0, success=False)
        if self.shaping is not Shaping.PARTIAL or verdict.partial is None:
            return inputs
        gained = compute_condition_gain(verdict.partial, self._met_at_start(task_id), inputs.gain)
        return replace(inputs, conditions=gained)

    def _find_which_goals_hold_at_start(self, task_id: str) -> tuple[bool, ...]:
        """Return for each goal of a task, in order, whether it is reached without any action."""
        task = self.suite.tasks[task_id]
        return GoalTest(task).evaluate_each_goal(task.initial, ())

    def _find_partial_success_at_start(self, task_id: str) -> Share:
        """Return the share of goal conditions that a plan without steps meets: its partial success."""
        task = self.suite.tasks[task_id]
        return GoalTest(task).find_partial_success(task.initial, (), self._at_start(task_id))


def reward(task: str, text: str, shaping: Shaping | str = Shaping.SUCCESS) -> float | None:
    """Return the reward of an answer, from 0 to 1; None if the task has no reward (`Grade.value`).

    Suites are opened at first use and cached, so that a training run can call this function for every answer.

    Args:
        task: benchmark, ability and id, as ``lamps:lamps/action_sequencing/light``; see `Suite.reference`.
        text: the answer.
        shaping: definition of the reward, as in `Reward`.

    Raises:
        InputError: the task or the shaping does not exist.
        DataError: the data cannot be obtained or is damaged.
    """
    reference = TaskReference.parse(task)
    return open_reward(reference, shaping)(reference.task_id, text)


def open_reward(task: TaskReference, shaping: Shaping | str) -> Reward:
    """Return the reward function of a task's benchmark and ability; it is opened once.

    Raises:
        InputError: there is no such suite or shaping.
        DataError: the data cannot be obtained or is damaged.
    """
    return _open_reward(task.benchmark, task.ability, find_enum_member(Shaping, shaping, "shaping"))


@cache
def open_reward_suite(benchmark: str, ability: Ability) -> Suite:
    """Return a suite (an ability in a benchmark) for computing rewards, which uses no planner.

    Later calls return the same suite. The benchmark is named as in `TaskReference`.

    Raises:
        InputError: there is no such suite.
        DataError: the data cannot be obtained or is damaged.
    """
    return open_suite(benchmark, ability, source=Source(planner=PlannerChoice.NONE))


@cache
def _open_reward(benchmark: str, ability: Ability, shaping: Shaping) -> Reward:
    return Reward(open_reward_suite(benchmark, ability), shaping)


def _drop_planner_that_tests_operators(suite: Suite) -> Suite:
    """Return a suite of transition modeling without the planner, which would test an answer's operators.

    Other suites stay as they are.
    """
    planned = suite.ability is Ability.TRANSITION_MODELING and suite.source.planner is not PlannerChoice.NONE
    return suite.reopen(source=replace(suite.source, planner=PlannerChoice.NONE)) if planned else suite


def make_metrics_from_reward_inputs(inputs: RewardInputs | None) -> dict[str, float]:
    """Return the attribute ``metrics`` of a `Grade`, by name of the metric.

    All metrics are 0 if the inputs are None.

    Args:
        inputs: the results of the answer from which its reward is computed, such as goals reached and errors.
    """
    if inputs is None:
        return dict.fromkeys(METRICS, 0.0)
    faults = {f"fault.{kind.value}": float(inputs.faults.get(kind, 0)) for kind in FaultKind}
    return {
        "success": float(inputs.success),
        "progress": inputs.gain,
        "faults": sum(faults.values()),
        **faults,
    }
