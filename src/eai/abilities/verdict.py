"""Verdicts: the result of scoring one answer, and the answer's contribution to each metric.

Each ability has its own class of verdicts in its own package. This module has the classes and functions that
several abilities use, and `Unreadable`, the reason why an answer cannot be read. A `Share` is the
contribution of an answer to a rate: a numerator and a denominator. `eai.results` adds up both and divides. A
`RewardInputs` holds the results for which a reward may pay; `eai.results.reward` chooses among these results.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple, TypeAlias

from typing_extensions import Self

from eai.abilities.repair import SmallestPlanRepair
from eai.base.json_value import Json
from eai.tasks.share import Share, TalliesByGoalKind
from eai.tasks.task import TaskExclusion
from eai.world.fault import FaultKind

ALL = "all"
"""Key of the total in counts by kind. The total counts a goal or clause of several kinds once."""


class ConfusionCounts(NamedTuple):
    """Numbers of true positives, false positives and false negatives."""

    true_positives: int
    false_positives: int
    false_negatives: int


NO_COUNTS = ConfusionCounts(0, 0, 0)
"""Counts of an answer that has no right, wrong or missed part."""


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """The error that ended the execution or the reading of an answer.

    Attributes:
        kind: kind of the error.
        step: number of the step or subgoal, from 0; None if the error does not concern a single step.
        detail: the reason for the error, in words.
        check: the failed check: the id of a domain's check (`Check.id`), ``unknown_action``, a value of
            `NameMisuseKind`, `UNREPLAYABLE` or `RAISED`. For an unreadable answer it is a value of
            `UnreadCause`, or None if the cause is unknown.
        objects: names of the objects in the reason, in the order in which the reason names them.
    """

    kind: FaultKind
    step: int | None
    detail: str
    check: str | None = None
    objects: tuple[str, ...] = ()


UNREPLAYABLE = "unreplayable"
"""Id of the check that an episode fails if a replay of the episode makes other observations."""

UNKNOWN_ACTION = "unknown_action"
"""Id of the check that an answer fails if it names an action that does not exist."""

RAISED = "raised"
"""Id of the check that is reported as failed if the scorer of an answer raises an exception."""


class AnswerSpanKind(str, Enum):
    """The ways in which a part of an answer's text can be treated.

    A `READ` part was read unchanged, and a `REPAIRED` part after a named repair. `PROSE` and `REASONING` do
    not belong to the answer. An `UNREAD` part makes the answer unreadable.
    """

    READ = "read"
    REPAIRED = "repaired"
    PROSE = "prose"
    REASONING = "reasoning"
    UNREAD = "unread"


@dataclass(frozen=True, slots=True, order=True)
class AnswerSpan:
    """A part of an answer's text, and how it was treated.

    Attributes:
        start: position of the first character, from 0.
        end: position after the last character.
        kind: how the part was treated.
    """

    start: int
    end: int
    kind: AnswerSpanKind


@dataclass(frozen=True, slots=True)
class RewardInputs:
    """The inputs of the reward: the properties of an answer on which its reward depends.

    Attributes:
        gain: reached share of the possible gain, from 0 to 1. For plans and subgoals it counts goals
            (`compute_goal_gain`). For goal interpretations and operators it is F1.
        success: whether the answer is right in all its parts. The gain is then 1.
        ended: whether an error ended the execution or the reading of the answer: its last action could not be
            executed, or the answer could not be read.
        faults: number of faults by kind; kinds without a fault are left out.
        added_actions: number of actions that a search added to execute subgoals. Rewards are divided by this
            number plus one. Otherwise an answer that copies the goal as a subgoal would be paid for the work
            of the search.
        conditions: reached share of the possible gain, from 0 to 1, counted in conditions of goals; None if
            it was not measured, or for answers that are not executed.
    """

    gain: float
    success: bool
    ended: bool
    faults: Mapping[FaultKind, int]
    added_actions: int = 0
    conditions: float | None = None


def compute_goal_gain(goals_reached: Sequence[bool], goals_at_start: Sequence[bool]) -> float | None:
    """Return the reached share of the goals that do not hold at the start, from 0 to 1; None if all hold.

    A goal that holds at the start earns nothing. If the answer undoes such a goal, the number of reached
    goals is reduced by one.

    Args:
        goals_reached: for each goal, in order, whether it holds at the end; empty if nothing was executed.
        goals_at_start: for each goal, in order, whether it holds in the initial state.
    """
    held = sum(goals_at_start)
    to_gain = len(goals_at_start) - held
    return max(0, sum(goals_reached) - held) / to_gain if to_gain else None


def compute_condition_gain(
    conditions_met: Share, conditions_met_at_start: Share, fallback_goal_gain: float
) -> float:
    """Return the rise of the share of met conditions, divided by the largest possible rise, from 0 to 1.

    An option is a list of conditions that together satisfy all goals. A task can have several options. The
    share is the number of an option's met conditions, divided by the number of its conditions.

    In two cases, return ``fallback_goal_gain`` instead: all conditions hold at the start, or all conditions
    of an option are met but a goal is missed. An example of such a goal: exactly two cups are on
    the table. It is missed if there are three.

    Args:
        conditions_met: number of met conditions and number of all conditions, of the option with the largest
            share of met conditions in the final state. No condition is met if nothing was executed.
        conditions_met_at_start: these two numbers for the initial state.
        fallback_goal_gain: the reached share of the goals that do not hold at the start
            (`compute_goal_gain`).
    """
    met, total = conditions_met
    met_at_start, total_at_start = conditions_met_at_start
    to_gain = total_at_start - met_at_start
    if not to_gain or (met == total and fallback_goal_gain < 1):
        return fallback_goal_gain
    return max(0.0, (met * total_at_start - met_at_start * total) / (total * to_gain))


def compute_plan_reward_inputs(
    goals_reached: Sequence[bool],
    goals_at_start: Sequence[bool],
    *,
    ended_by_error: bool,
    faults: Mapping[FaultKind, int],
) -> RewardInputs | None:
    """Return the inputs of the reward for a plan or an episode, or None if all goals hold at the start.

    Args:
        goals_reached: for each goal, in order, whether it holds at the end; empty if nothing was executed.
        goals_at_start: for each goal, in order, whether it holds in the initial state.
        ended_by_error: whether the last action could not be executed.
        faults: number of faults by kind.
    """
    gained = compute_goal_gain(goals_reached, goals_at_start)
    if gained is None:
        return None
    return RewardInputs(gained, gained == 1 and not ended_by_error, ended_by_error, faults)


def compute_reward_inputs_from_part_counts(
    right_wrong_missed: tuple[int, int, int],
    error: ErrorReport | None,
    faults: Mapping[FaultKind, int],
    ill_formed_or_unknown_parts: int = 0,
) -> RewardInputs | None:
    """Return the inputs of the reward for an answer whose goals or clauses are compared one by one.

    Return None if the task asks for no goals or clauses.

    Args:
        right_wrong_missed: numbers of right, wrong and missed parts.
        error: the error that ended the execution or the reading of the answer, or None.
        faults: number of other faults by kind.
        ill_formed_or_unknown_parts: number of ill-formed parts and parts with unknown names. They count
            as wrong.
    """
    hit, extra, missed = right_wrong_missed
    if not hit + missed:
        return None
    if error is not None:
        faults = Counter(faults) + Counter((error.kind,))
    return RewardInputs(
        gain=2 * hit / (2 * hit + extra + ill_formed_or_unknown_parts + missed),
        success=not extra and not missed and not faults,
        ended=error is not None,
        faults=faults,
    )


@dataclass(frozen=True, slots=True)
class Verdict:
    """The verdict on one answer of any ability.

    Attributes:
        excluded: why all statistics leave the task out; None if the task is scored.
        error: the error that ended the execution or the reading of the answer, or None.
        repairs: names of the repairs that were needed to read the answer.
        spans: parts of the answer's text and how each was treated, in order; empty if the rules for scoring
            (protocol) do not record them.
        repair: the fewest edits that make the answer right; None if no repair was searched for.
    """

    excluded: TaskExclusion | None = None
    error: ErrorReport | None = None
    repairs: tuple[str, ...] = ()
    spans: tuple[AnswerSpan, ...] = field(default=(), compare=False)
    repair: SmallestPlanRepair | None = None

    def to_verdict_on_missing_answer(self) -> Self:
        """Return this verdict without its error: a missing answer is no error, unlike an empty answer."""
        return replace(self, error=None)

    @property
    def success(self) -> bool | None:
        """Whether the answer is right in all its parts.

        None for excluded tasks, and for abilities whose answers do not succeed or fail.
        """
        return None

    def find_contradiction(self) -> str | None:
        """Return a sentence on fields of this verdict that contradict each other by `strict`, or None."""
        return None

    @property
    def values_by_column(self) -> Mapping[str, Json]:
        """The verdict's values, by the columns of `eai.results.lines.AnswerTableLine`."""
        return {}

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the inputs of the reward for an answer, or None if nothing can be earned.

        The task must not be excluded.

        Args:
            goals_at_start: for each goal of the task, in order, whether it holds in the initial state;
                empty for answers that are not executed.

        Raises:
            NotImplementedError: no reward pays for answers of this ability.
        """
        raise NotImplementedError(
            f"{type(self).__name__} does not define how answers are rewarded: "
            "implement its method `compute_reward_inputs`"
        )

    def is_step_an_action(self, step_index: int) -> bool:
        """Whether a step of this verdict's `VerdictExplanation`, counted from 0, is an action that was tried.

        The explanation of a game also has steps for other commands, such as the command to look.
        """
        return True

    @property
    def name_of_used_planner(self) -> str | None:
        """Name of the planner that tested the answer; None without a planner, or in files of old versions."""
        return None

    @property
    def outcome_of_fallback_planner(self) -> str | None:
        """Outcome of the second planner; None if the first planner gave the result, or if no planner ran."""
        return None


@dataclass(frozen=True, slots=True)
class SummaryCounts:
    """The counts of an answer in tables over many answers, if they differ from the fields of its verdict.

    Only some protocols (scoring rules) need such counts. All other verdicts are counted by their own fields.

    Attributes:
        success: whether the answer counts as a success.
        goals: numbers of satisfied goals and of all goals that count, by kind of goal.
        errors: number of errors that count, by kind of error; a kind that is not listed counts 0 times.
    """

    success: bool
    goals: TalliesByGoalKind
    errors: Mapping[FaultKind, int]


@dataclass(frozen=True, slots=True)
class PlanVerdict(Verdict):
    """The verdict on a plan.

    Attributes:
        executable: whether the plan ran to its end.
        success: whether all goals hold.
        additional_steps: number of needless steps in the answer; the execution skipped these steps.
        goals: numbers of satisfied goals and of all goals, by kind of goal.
        goals_satisfied: for each goal of the task, in order, whether the plan reaches it.
        partial: number of met conditions and of all conditions in one option (`eai.tasks.goal_test`): a list
            of conditions that satisfies all goals. The option with the largest share of met conditions
            counts. None if an old version stored the verdict.
        counted: the counts of the answer in a summary; None if they follow from the verdict.
        refused: the reason in the answer why the task is impossible, or the question in the answer; None for
            answers that do not decline the task.
    """

    executable: bool | None = None
    success: bool | None = None
    additional_steps: int | None = None
    goals: TalliesByGoalKind | None = None
    goals_satisfied: tuple[bool, ...] = ()
    partial: Share | None = None
    counted: SummaryCounts | None = None
    refused: str | None = None

    @property
    def is_task_declined_by_answer(self) -> bool:
        """Whether the answer calls the task impossible, or asks which object the instruction means."""
        return self.refused is not None

    def find_contradiction(self) -> str | None:
        """Return a sentence on fields that contradict each other by the rules of `strict`, or None.

        A plan succeeds if no error ended it and all goals hold, or if it rightly declines the task.
        """
        if self.excluded is not None or self.success is None or self.refused is not None:
            return None
        if self.success and self.error is not None:
            return f"success is true, although the error {self.error.kind.value} ended the answer"
        if self.success and not all(self.goals_satisfied):
            return "success is true, although goals_satisfied has a goal that is missed"
        has_all_goals = bool(self.goals_satisfied) and all(self.goals_satisfied)
        if has_all_goals and any(met != total for met, total in self.goals or ()):
            return "goals has a goal that is missed, although goals_satisfied has none"
        if not self.success and has_all_goals and self.executable and self.error is None:
            return "success is false, although all goals hold and no error ended the answer"
        return None

    @property
    def values_by_column(self) -> Mapping[str, Json]:
        """Mapping from table columns to the verdict's values.

        The columns are: whether the plan ran to its end, the number of additional steps, and goals by kind.
        """
        goals = {} if self.goals is None else self.goals._asdict()
        met = {f"{kind}_met": float(share.numerator) for kind, share in goals.items()}
        total = {f"{kind}_total": float(share.denominator) for kind, share in goals.items()}
        conditions_met, conditions = (None, None) if self.partial is None else self.partial
        return {
            "executable": self.executable,
            "additional_steps": self.additional_steps,
            **met,
            **total,
            "conditions_met": conditions_met,
            "conditions": conditions,
        }

    def count_faults_by_kind(self) -> Mapping[FaultKind, int]:
        """Return the number of faults by kind: additional steps, and the error that ended the plan."""
        faults = Counter({FaultKind.ADDITIONAL_STEP: self.additional_steps or 0})
        if self.error is not None:
            faults[self.error.kind] += 1
        return +faults

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the inputs of the reward for the plan, or None if all goals hold at the start.

        An answer that rightly declines the task gets the full gain, 1.
        """
        if self.refused is not None:
            return RewardInputs(float(self.success or 0), bool(self.success), ended=False, faults={})
        ended = not self.executable
        earned = compute_plan_reward_inputs(
            self.goals_satisfied, goals_at_start, ended_by_error=ended, faults=self.count_faults_by_kind()
        )
        if earned is None:
            return None
        return replace(earned, success=bool(self.success) and earned.gain == 1)

    def to_verdict_on_missing_answer(self) -> Self:
        """Turn this verdict, which must be on an empty answer, into the verdict on a missing answer.

        No goal counts as reached, even if it holds at the start.
        """
        unanswered = Verdict.to_verdict_on_missing_answer(self)
        if self.excluded is not None:
            return unanswered
        goals = (
            None if self.goals is None else TalliesByGoalKind(*[Share(0, whole) for _, whole in self.goals])
        )
        return replace(
            unanswered,
            executable=False,
            success=False,
            goals=goals,
            goals_satisfied=(False,) * len(self.goals_satisfied),
            partial=None if self.partial is None else Share(0, self.partial.denominator),
            counted=None,
        )


@dataclass(frozen=True, slots=True)
class Unreadable:
    """The reason why an answer cannot be read.

    Attributes:
        reason: the reason in words, with its position in the text if there is one.
        step: number of the step that cannot be read, from 0; None if the reason is not about one step.
        spans: parts of the answer's text, and how each was treated.
    """

    reason: str
    step: int | None = None
    spans: tuple[AnswerSpan, ...] = field(default=(), compare=False)


ShareByMetric: TypeAlias = Mapping[str, Share]
"""Mapping from names of metrics to the numerator and denominator that one answer adds to each."""

EMPTY_SHARE = Share(0, 0)
"""The contribution of an answer to a rate for which the answer does not count: 0 of 0."""


ZERO_SHARE, FULL_SHARE = Share(0.0, 1), Share(1.0, 1)
"""Contributions to a rate of success: 0 of 1 for a failure, and 1 of 1 for a full success."""


def make_rate_contribution_of_answer(has_property_or_share: bool | float | None) -> Share:
    """Return the contribution of one answer to a rate over all answers.

    Args:
        has_property_or_share: whether the answer has the counted property. A number from 0 to 1 if
            only a part of the answer has the property.
    """
    if not has_property_or_share:
        return ZERO_SHARE
    return FULL_SHARE if has_property_or_share == 1 else Share(float(has_property_or_share), 1)


def make_confusion_shares(prefix: str, confusion: ConfusionCounts) -> dict[str, Share]:
    """Return the numerator and the denominator that one answer adds to precision, recall and F1, by metric.

    Each metric is a ratio of two sums over all answers. F1 is ``2 TP / (2 TP + FP + FN)``, the harmonic mean
    of precision and recall.
    """
    hit, extra, missed = confusion
    return {
        f"{prefix}.precision": Share(hit, hit + extra),
        f"{prefix}.recall": Share(hit, hit + missed),
        f"{prefix}.f1": Share(2 * hit, 2 * hit + extra + missed),
    }


def sum_confusion_counts(confusions: Iterable[ConfusionCounts]) -> ConfusionCounts:
    """Return the sum of several counts of true positives, false positives and false negatives."""
    hits, extras, missed = 0, 0, 0
    for confusion in confusions:
        hits += confusion.true_positives
        extras += confusion.false_positives
        missed += confusion.false_negatives
    return ConfusionCounts(hits, extras, missed)
