"""Verdicts: what scoring says of one answer, and what that adds to each metric.

A verdict is a value of its ability's own class, in the ability's package, which has what the ability has to
say and nothing else. Here is what several abilities say, and why nothing can be read from an answer. A
`Share` is what one answer adds to a rate: a numerator and a denominator, for `eai.results` to divide. A
`Merit` is what an answer may be paid for (`eai.results.reward` says by which of it), between 0 and 1.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple, TypeAlias

from typing_extensions import Self

from eai.abilities.repair import Repair
from eai.base.json_value import Json
from eai.tasks.share import GoalTallies, Share
from eai.tasks.task import TaskExclusion
from eai.world.fault import FaultKind

ALL = "all"
"""The key of all goals, or clauses, in counts by kind: each once, those of several kinds and of none too."""


class Confusion(NamedTuple):
    """True positives, false positives and false negatives."""

    true_positives: int
    false_positives: int
    false_negatives: int


NO_COUNTS = Confusion(0, 0, 0)
"""Counts of an answer in which no part is right, wrong or missing."""


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """The error that ended an answer.

    Attributes:
        kind: the kind of error.
        step: the step or subgoal, counted from 0, if it is one in particular.
        detail: the reason in words.
        check: the id of the declared check that failed (`Check.id`), or of the test of names
            (``unknown_action``, or a value of `MisuseKind`), or `UNREPLAYABLE` or `RAISED`; None for an
            answer that cannot be read.
        objects: the names of the objects that the reason speaks of, in the order of its words.
    """

    kind: FaultKind
    step: int | None
    detail: str
    check: str | None = None
    objects: tuple[str, ...] = ()


UNREPLAYABLE = "unreplayable"
"""The check that an episode fails if its observations differ from those of its replay."""

UNKNOWN_ACTION = "unknown_action"
"""The test of names that an answer fails if it names an action that does not exist."""

RAISED = "raised"
"""The check that an answer fails if its scorer raises an exception."""


class SpanKind(str, Enum):
    """The fate of a part of an answer's text.

    `READ` is a part that was read as it is, `REPAIRED` one that was read after a named repair. `PROSE` and
    `REASONING` are no part of the answer. `UNREAD` is the part for which an answer cannot be read.
    """

    READ = "read"
    REPAIRED = "repaired"
    PROSE = "prose"
    REASONING = "reasoning"
    UNREAD = "unread"


@dataclass(frozen=True, slots=True, order=True)
class Span:
    """A part of an answer's text.

    Attributes:
        start: position of its first character, from 0.
        end: position after its last character.
        kind: what became of it.
    """

    start: int
    end: int
    kind: SpanKind


@dataclass(frozen=True, slots=True)
class Merit:
    """The merits in a verdict that an answer may be paid for.

    Attributes:
        gain: for plans and subgoals the goals gained, of all that there are to gain; for interpretations of
            goals and for operators F1. Between 0 and 1.
        success: whether the answer is right as a whole, which takes a gain of 1.
        ended: whether an error ended it: its last action, if it has any, could not be carried out.
        faults: how often each kind of fault was diagnosed; kinds that were not are left out.
        added: how many actions a search had to add to carry out subgoals. All that they earn is divided by
            one more, so that the goal copied as a subgoal is not paid for what the search did.
        conditions: the gain in partial success, between 0 and 1; None if it was not measured, or if answers
            are not carried out.
    """

    gain: float
    success: bool
    ended: bool
    faults: Mapping[FaultKind, int]
    added: int = 0
    conditions: float | None = None


def gain(reached: Sequence[bool], at_start: Sequence[bool]) -> float | None:
    """How much of what there is to gain is gained, from 0 to 1; None where there is nothing.

    A goal that holds at the start earns nothing, and costs one that is reached if it is undone.

    Args:
        reached: for each goal, in order, whether it is reached at the end; none if nothing was carried out.
        at_start: whether it is reached where nothing is done.
    """
    held = sum(at_start)
    to_gain = len(at_start) - held
    return max(0, sum(reached) - held) / to_gain if to_gain else None


def gain_of_conditions(partial: Share, at_start: Share, of_goals: float) -> float:
    """Return the gain in partial success, as a share of the possible gain.

    The conditions of one option can all be met although a goal is missed: if more than exactly two cups are
    on the table. Then, and if it is so at the start, the gain of goals is the gain.

    Args:
        partial: the conditions met at the end in the best option, of how many; 0 if nothing was carried out.
        at_start: the same if nothing is done.
        of_goals: the gain of goals.
    """
    met, total = partial
    met_at_start, total_at_start = at_start
    to_gain = total_at_start - met_at_start
    if not to_gain or (met == total and of_goals < 1):
        return of_goals
    return max(0.0, (met * total_at_start - met_at_start * total) / (total * to_gain))


def merit_of_actions(
    reached: Sequence[bool], at_start: Sequence[bool], *, ended: bool, faults: Mapping[FaultKind, int]
) -> Merit | None:
    """The merit of actions, as a plan or one a turn; None where there is nothing to earn.

    Args:
        reached: for each goal, in order, whether it is reached now; none if nothing was carried out.
        at_start: whether it is reached where nothing is done.
        ended: whether the last action could not be carried out.
        faults: how often each kind of fault was made.
    """
    gained = gain(reached, at_start)
    return None if gained is None else Merit(gained, gained == 1 and not ended, ended, faults)


def merit_of_parts(
    counts: tuple[int, int, int],
    error: ErrorReport | None,
    faults: Mapping[FaultKind, int],
    strangers: int = 0,
) -> Merit | None:
    """The merit of what is compared part by part; None where nothing is asked for.

    Args:
        counts: how many parts are right, are wrong, and are missed.
        error: the error that ended the answer, if one did.
        faults: how often each other kind of fault was made.
        strangers: how many parts mean nothing; each is as wrong as one that is not so.
    """
    hit, extra, missed = counts
    if not hit + missed:
        return None
    if error is not None:
        faults = Counter(faults) + Counter((error.kind,))
    return Merit(
        gain=2 * hit / (2 * hit + extra + strangers + missed),
        success=not extra and not missed and not faults,
        ended=error is not None,
        faults=faults,
    )


@dataclass(frozen=True, slots=True)
class Verdict:
    """The verdict on one answer, whatever the ability.

    Attributes:
        excluded: why the task is left out of all statistics, or None if it is scored.
        error: what ended the answer.
        repairs: the names of the repairs that parsing made.
        spans: what became of the parts of the answer's text, in order; none if the protocol does not say.
        repair: the fewest edits that make the answer right; None where they were not looked for.
    """

    excluded: TaskExclusion | None = None
    error: ErrorReport | None = None
    repairs: tuple[str, ...] = ()
    spans: tuple[Span, ...] = field(default=(), compare=False)
    repair: Repair | None = None

    def without_answer(self) -> Self:
        """This verdict on an empty answer as one on no answer: it fails, but by no error of the model's."""
        return replace(self, error=None)

    @property
    def columns(self) -> Mapping[str, Json]:
        """The columns that it fills in the line of an answer (`eai.results.lines.AnswerLine`)."""
        return {}

    def merit(self, at_start: Sequence[bool]) -> Merit | None:
        """The merit of the answer to a task that is not left out; None where there is nothing to earn.

        Args:
            at_start: for each goal of the task, in order, whether it is reached where nothing is done; none
                for answers that are not carried out.

        Raises:
            NotImplementedError: answers to this ability are not paid for.
        """
        raise NotImplementedError(f"{type(self).__name__} does not say what its answer has earned")

    def is_action(self, step: int) -> bool:
        """Whether an action was tried at a step of the explanation, by its number from 0."""
        return True

    @property
    def judge(self) -> str | None:
        """The planner that judged the answer, by name; None if none did, or in older records."""
        return None

    @property
    def left_to(self) -> str | None:
        """How the second of two planners ended to which the first one left it; None if it decided itself."""
        return None


@dataclass(frozen=True, slots=True)
class Counted:
    """The way an answer counts in a summary, where that is not what its verdict says.

    Attributes:
        success: whether it counts as a success.
        goals: the satisfied goals that count.
        errors: how often each kind of error counts; a kind that is not there counts never.
    """

    success: bool
    goals: GoalTallies
    errors: Mapping[FaultKind, int]


ASK, REFUSE = "ASK", "IMPOSSIBLE"
"""The commands by which who acts asks what is meant, where an instruction may fit several objects, and says
that the task cannot be done, where that may be so."""


def is_question(command: str) -> bool:
    """Whether a command asks what is meant, with any question, as in ``ASK(which one?)``."""
    return _begins_with(ASK, command)


def refusal_in(command: str) -> str | None:
    """Why a task cannot be done, as in ``IMPOSSIBLE(no stove works)``; None of any other command."""
    if not _begins_with(REFUSE, command):
        return None
    return command.partition(REFUSE)[2].strip().removeprefix("(").removesuffix(")").strip()


def _begins_with(word: str, command: str) -> bool:
    return command.split("(")[0].split(maxsplit=1)[:1] == [word]


@dataclass(frozen=True, slots=True)
class PlanVerdict(Verdict):
    """The verdict on a plan.

    Attributes:
        executable: whether it ran to its end.
        success: whether all goals hold.
        additional_steps: how many steps were skipped because they were not needed.
        goals: satisfied goals by kind.
        goals_satisfied: for each goal of the task, in order, whether it is reached.
        partial: number of conditions met, and of all conditions, in the option that is met best
            (`eai.tasks.goal_test`); None in older records.
        counted: what it counts as in a summary; None for what the verdict says.
        refused: why the answer gives no plan: the task is impossible, it says, or its question.
    """

    executable: bool | None = None
    success: bool | None = None
    additional_steps: int | None = None
    goals: GoalTallies | None = None
    goals_satisfied: tuple[bool, ...] = ()
    partial: Share | None = None
    counted: Counted | None = None
    refused: str | None = None

    @property
    def declines(self) -> bool:
        """Whether the answer says that the task is impossible, or asks what it means."""
        return self.refused is not None

    @property
    def columns(self) -> Mapping[str, Json]:
        """Whether it ran, its additional steps, and its goals by kind."""
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

    def faults(self) -> Mapping[FaultKind, int]:
        """How often each kind of fault was made: additional steps, and the error that ended it."""
        faults = Counter({FaultKind.ADDITIONAL_STEP: self.additional_steps or 0})
        if self.error is not None:
            faults[self.error.kind] += 1
        return +faults

    def merit(self, at_start: Sequence[bool]) -> Merit | None:
        """Of what is carried out; of an answer that there is no plan, whether that is so."""
        if self.refused is not None:
            return Merit(float(self.success or 0), bool(self.success), ended=False, faults={})
        ended = not self.executable
        earned = merit_of_actions(self.goals_satisfied, at_start, ended=ended, faults=self.faults())
        if earned is None:
            return None
        return replace(earned, success=bool(self.success) and earned.gain == 1)

    def without_answer(self) -> Self:
        """As of any verdict; no goal is reached, though it may hold from the beginning."""
        unanswered = Verdict.without_answer(self)
        if self.excluded is not None:
            return unanswered
        goals = None if self.goals is None else GoalTallies(*[Share(0, whole) for _, whole in self.goals])
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
    """Why an answer cannot be read.

    Attributes:
        reason: the reason in words, with the place in the text if there is one.
        step: number of the step that cannot be read, from 0, if it is one step.
        spans: what became of the parts of the text.
    """

    reason: str
    step: int | None = None
    spans: tuple[Span, ...] = field(default=(), compare=False)


Shares: TypeAlias = Mapping[str, Share]
"""The contributions of one answer, by the name of the metric."""

NOTHING = Share(0, 0)
"""The contribution of an answer to a rate that is not about it."""


NONE, ONE = Share(0.0, 1), Share(1.0, 1)
"""The contributions of nearly all answers to a share of all answers."""


def of_all(counted: bool | float | None) -> Share:
    """The contribution of one answer to a share of all answers."""
    if not counted:
        return NONE
    return ONE if counted == 1 else Share(float(counted), 1)


def confusion_shares(prefix: str, confusion: Confusion) -> dict[str, Share]:
    """The contributions of counts to precision, recall and F1, each a ratio of sums over answers.

    F1 is ``2 TP / (2 TP + FP + FN)``, which is the harmonic mean of the other two.
    """
    hit, extra, missed = confusion
    return {
        f"{prefix}.precision": Share(hit, hit + extra),
        f"{prefix}.recall": Share(hit, hit + missed),
        f"{prefix}.f1": Share(2 * hit, 2 * hit + extra + missed),
    }


def add(confusions: Iterable[Confusion]) -> Confusion:
    """The sum of confusion counts."""
    hits, extras, missed = 0, 0, 0
    for confusion in confusions:
        hits += confusion.true_positives
        extras += confusion.false_positives
        missed += confusion.false_negatives
    return Confusion(hits, extras, missed)
