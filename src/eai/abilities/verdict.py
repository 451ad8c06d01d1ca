"""Verdicts: what scoring says of one answer, for any ability.

A verdict is a value of its ability's own class, which has what the ability has to say and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple, TypeAlias, TypeVar

from eai.abilities.transition_modeling.report import OperatorReport
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind

ALL = "all"
"""The key of all goals, or clauses, in counts by kind: each once, those of several kinds and of none too."""

Json: TypeAlias = bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"] | None


class Tally(NamedTuple):
    """How many of the goals of a kind are satisfied."""

    satisfied: int | float
    total: int | float


class GoalTallies(NamedTuple):
    """The tallies of the three kinds of goal."""

    state: Tally
    relation: Tally
    action: Tally

    def __reduce__(self) -> tuple[Callable[..., GoalTallies], tuple[float, ...]]:
        return GoalTallies.of_numbers, (*self.state, *self.relation, *self.action)

    @staticmethod
    def of_numbers(*numbers: float) -> GoalTallies:
        """The tallies of these numbers: how many of each kind are satisfied, and of how many, in turn."""
        return GoalTallies(*map(Tally, numbers[::2], numbers[1::2]))

    @property
    def all_satisfied(self) -> bool:
        """Whether every goal is satisfied."""
        return all(tally.satisfied == tally.total for tally in self)


class Confusion(NamedTuple):
    """True positives, false positives and false negatives."""

    true_positives: int
    false_positives: int
    false_negatives: int


def fields_in_order(value: Any) -> tuple[object, ...]:
    """The fields of a dataclass, which are the arguments that make it."""
    return tuple([getattr(value, name) for name in value.__dataclass_fields__])


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """What ended an answer.

    Attributes:
        kind: the kind of error.
        step: the step or subgoal, counted from 0, if it is one in particular.
        detail: the reason in words.
        check: the id of the declared check that failed (`Check.id`), or of the test of names
            (``unknown_action``, or a value of `MisuseKind`); None for an answer that cannot be read.
        objects: the names of the objects that the reason speaks of, in the order of its words.
    """

    kind: FaultKind
    step: int | None
    detail: str
    check: str | None = None
    objects: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[type[ErrorReport], tuple[object, ...]]:
        return type(self), fields_in_order(self)


class SubgoalCategory(str, Enum):
    """The outcomes of subgoal decomposition (reference: ``subgoal_eval_utils.py``)."""

    CORRECT = "correct"
    RUNTIME = "runtime"
    GOAL_UNREACHABLE = "goal_unreachable"
    HALLUCINATION = "hallucination"
    NOT_PARSEABLE = "not_parseable"


@dataclass(frozen=True, slots=True)
class Verdict:
    """What scoring says of one answer, whatever the ability.

    Attributes:
        excluded: why the task is left out of all statistics, or None if it is scored.
        error: what ended the answer.
        repairs: the names of the repairs that parsing made.
    """

    excluded: str | None = None
    error: ErrorReport | None = None
    repairs: tuple[str, ...] = ()

    def __reduce__(self) -> tuple[type[Verdict], tuple[object, ...]]:
        """Workers send verdicts back by the thousand: as their fields in order, in a third of the time."""
        return type(self), fields_in_order(self)


@dataclass(frozen=True, slots=True)
class Counted:
    """What an answer counts as in a summary, where that is not what its verdict says.

    Attributes:
        success: whether it counts as a success.
        goals: the satisfied goals that count.
        errors: how often each kind of error counts; a kind that is not there counts never.
    """

    success: bool
    goals: GoalTallies
    errors: tuple[tuple[FaultKind, int], ...]


@dataclass(frozen=True, slots=True)
class PlanVerdict(Verdict):
    """What scoring says of a plan.

    Attributes:
        executable: whether it ran to its end.
        success: whether all goals hold.
        additional_steps: how many steps were skipped because they were not needed.
        goals: satisfied goals by kind.
        goals_satisfied: for each goal of the task, in order, whether it is reached.
        counted: what it counts as in a summary; None for what the verdict says.
    """

    executable: bool | None = None
    success: bool | None = None
    additional_steps: int | None = None
    goals: GoalTallies | None = None
    goals_satisfied: tuple[bool, ...] = ()
    counted: Counted | None = None


@dataclass(frozen=True, slots=True)
class SubgoalVerdict(PlanVerdict):
    """What scoring says of a sequence of subgoals.

    Attributes:
        category: the outcome.
        goals_elsewhere: whether the goals are those of another way to carry the subgoals out than the
            reported one, which reaches fewer.
        errors: the kinds of all errors of the reported way to carry them out, in order.
        offences: what is wrong with names, each kind once.
        search: why the search for a way ended, or None if there was none.
        attempts: how many actions it tried.
    """

    category: SubgoalCategory | None = None
    goals_elsewhere: bool = False
    errors: tuple[FaultKind, ...] = ()
    offences: tuple[str, ...] = ()
    search: str | None = None
    attempts: int | None = None


@dataclass(frozen=True, slots=True)
class GoalVerdict(Verdict):
    """What scoring says of an interpretation of goals.

    Attributes:
        counts: goals found, invented and missed, by kind, and ``all`` together. What is ill-formed or names
            what does not exist is not among those invented (the reference counts a part of it).
        predicted: how many goals the answer states, those included that are not counted.
        ill_formed: how many of them lack a part.
        hallucinated: for each goal that names what does not exist, the first such name.
        unknown_predicates: the predicates that there are not.
        matched: the stated goals that are right, as texts, each as often as it counts.
        wrong: those that are wrong, likewise; the entries that lack a part come first, as they are written.
        missing: the conditions of the task that are not stated, as texts.
        aborts: whether the reference would end its whole run here.
    """

    counts: Mapping[str, Confusion] | None = None
    predicted: int = 0
    ill_formed: int = 0
    hallucinated: tuple[str, ...] = ()
    unknown_predicates: tuple[str, ...] = ()
    matched: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    aborts: bool = False


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """What scoring says of operators.

    Attributes:
        success: whether a planner reaches the goal with them; None if none was asked.
        counts: clauses matched, additional and missing, by side (precondition, effect) and category; or
            predicates, if the rules count those.
        literals: the same in literals, by side: partial credit for clauses of which a part is right; None if
            the rules do not give it.
        planner: what the planner made of them.
        task_categories: the task's own categories, the first the more telling one.
        operators: what comparing each operator with the gold one found out.
        plan: the steps of the plan that was found.
        planner_detail: what else the planner says.
        planner_name: which planner was asked, with its version; None if none was, or in older records.
    """

    success: bool | None = None
    counts: Mapping[str, Mapping[str, Confusion]] | None = None
    literals: Mapping[str, Confusion] | None = None
    planner: PlannerOutcome | None = None
    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""
    planner_name: str | None = None


V = TypeVar("V", bound=Verdict)


def without_answer(verdict: V) -> V:
    """The verdict on an empty answer as one on no answer at all.

    It fails, but by no error of the model's, and no goal is reached, though it may hold from the beginning.
    """
    if not isinstance(verdict, PlanVerdict) or verdict.excluded is not None:
        return replace(verdict, error=None)
    goals = None if verdict.goals is None else GoalTallies(*(Tally(0, t.total) for t in verdict.goals))
    failed = replace(
        verdict,
        error=None,
        executable=False,
        success=False,
        goals=goals,
        goals_satisfied=(False,) * len(verdict.goals_satisfied),
        counted=None,
    )
    return replace(failed, category=None) if isinstance(failed, SubgoalVerdict) else failed
