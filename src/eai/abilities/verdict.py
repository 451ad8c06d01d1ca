"""Verdicts: what scoring says of one answer, for any ability.

A verdict is a value; `fields_of` gives its part of a line of ``records.jsonl``. Fields that an ability does
not use are None.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from eai.abilities.transition_modeling.report import OperatorReport
from eai.pddl.matching import SideMatch
from eai.pddl.planning import PlannerOutcome
from eai.world.fault import FaultKind

Json: TypeAlias = bool | int | float | str | Sequence["Json"] | Mapping[str, "Json"] | None


class Tally(NamedTuple):
    """How many of the goals of a kind are satisfied."""

    satisfied: float
    total: float


class GoalTallies(NamedTuple):
    """The tallies of the three kinds of goal."""

    state: Tally
    relation: Tally
    action: Tally

    @property
    def all_satisfied(self) -> bool:
        """Whether every goal is satisfied."""
        return all(tally.satisfied == tally.total for tally in self)


class Confusion(NamedTuple):
    """True positives, false positives and false negatives."""

    true_positives: int
    false_positives: int
    false_negatives: int


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """What ended an answer: the kind of error, the step (counted from 0) and the reason in words."""

    kind: FaultKind
    step: int | None
    detail: str


class SubgoalCategory(str, Enum):
    """The outcomes of subgoal decomposition (reference: ``subgoal_eval_utils.py``)."""

    CORRECT = "correct"
    RUNTIME = "runtime"
    GOAL_UNREACHABLE = "goal_unreachable"
    HALLUCINATION = "hallucination"
    NOT_PARSEABLE = "not_parseable"


Counts: TypeAlias = Mapping[str, "Confusion | Mapping[str, Confusion]"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """What scoring says of one answer.

    Attributes:
        excluded: why the task is left out of all statistics, or None if it is scored.
        executable: a plan ran to its end.
        success: all goals hold.
        error: what ended the answer.
        additional_steps: how many steps were skipped because they were not needed.
        category: the outcome of subgoal decomposition.
        goals: satisfied goals by kind.
        counts: confusion counts by kind of goal, or by side and category of predicates.
        planner: what the planner made of the answer's operators.
        repairs: the names of the repairs that parsing made.
        details: whatever else an ability has to say.
    """

    excluded: str | None = None
    executable: bool | None = None
    success: bool | None = None
    error: ErrorReport | None = None
    additional_steps: int | None = None
    category: SubgoalCategory | None = None
    goals: GoalTallies | None = None
    counts: Counts | None = None
    planner: PlannerOutcome | None = None
    repairs: tuple[str, ...] = ()
    details: Mapping[str, Json] | None = None


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
        goals_satisfied: for each goal of the task, in order, whether it is reached.
        counted: what it counts as in a summary; None for what the verdict says.
    """

    goals_satisfied: tuple[bool, ...] = ()
    counted: Counted | None = None


@dataclass(frozen=True, slots=True)
class SubgoalVerdict(PlanVerdict):
    """What scoring says of a sequence of subgoals.

    Attributes:
        errors: the kinds of all errors of the reported way to carry them out, in order.
        offences: what is wrong with names, each kind once.
        search: why the search for a way ended, or None if there was none.
        attempts: how many actions it tried.
    """

    errors: tuple[FaultKind, ...] = ()
    offences: tuple[str, ...] = ()
    search: str | None = None
    attempts: int | None = None


@dataclass(frozen=True, slots=True)
class GoalVerdict(Verdict):
    """What scoring says of an interpretation of goals.

    Attributes:
        predicted: how many goals the answer states.
        ill_formed: how many of them lack a part.
        hallucinated: for each goal that names what does not exist, the first such name.
        unknown_predicates: the predicates that there are not.
        aborts: whether the reference would end its whole run here.
    """

    predicted: int = 0
    ill_formed: int = 0
    hallucinated: tuple[str, ...] = ()
    unknown_predicates: tuple[str, ...] = ()
    aborts: bool = False


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """What scoring says of operators.

    Attributes:
        task_categories: the task's own categories, the first the more telling one.
        operators: what comparing each operator with the gold one found out.
        plan: the steps of the plan that was found.
        planner_detail: what else the planner says.
    """

    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""


def fields_of(verdict: Verdict) -> dict[str, Json]:
    """The JSON fields of a verdict, as DESIGN section 7 names them."""
    fields: dict[str, Json] = {
        "status": "scored" if verdict.excluded is None else "excluded",
        "excluded_reason": verdict.excluded,
        "executable": verdict.executable,
        "success": verdict.success,
        "error": None if verdict.error is None else _error(verdict.error),
        "additional_steps": verdict.additional_steps,
        "category": verdict.category and verdict.category.value,
        "goals": None if verdict.goals is None else _goals(verdict.goals),
        "counts": None if verdict.counts is None else {k: _counts(c) for k, c in verdict.counts.items()},
        "planner": verdict.planner and verdict.planner.value,
        "repairs": list(verdict.repairs),
    }
    return {**fields, **_own(verdict), **(verdict.details or {})}


def _own(verdict: Verdict) -> dict[str, Json]:
    """The fields that only verdicts of this ability have."""
    match verdict:
        case SubgoalVerdict():
            return {
                "goals_satisfied": list(verdict.goals_satisfied),
                "counted": _counted(verdict.counted),
                "errors": [kind.value for kind in verdict.errors],
                "offences": list(verdict.offences),
                "search": verdict.search,
                "attempts": verdict.attempts,
            }
        case PlanVerdict():
            return {
                "goals_satisfied": list(verdict.goals_satisfied),
                "counted": _counted(verdict.counted),
            }
        case GoalVerdict():
            return {
                "predicted": verdict.predicted,
                "ill_formed": verdict.ill_formed,
                "hallucinated": list(verdict.hallucinated),
                "unknown_predicates": list(verdict.unknown_predicates),
                "aborts": verdict.aborts,
            }
        case OperatorVerdict():
            return {
                "task_categories": list(verdict.task_categories),
                "operators": [_operator(report) for report in verdict.operators],
                "plan": list(verdict.plan),
                "planner_detail": verdict.planner_detail,
            }
        case _:
            return {}


def _counted(counted: Counted | None) -> Json:
    if counted is None:
        return None
    errors: dict[str, Json] = {kind.value: times for kind, times in counted.errors}
    return {"success": counted.success, "goals": _goals(counted.goals), "errors": errors}


def _error(error: ErrorReport) -> Json:
    return {"kind": error.kind.value, "step": error.step, "detail": error.detail}


def _goals(goals: GoalTallies) -> Json:
    return {kind: list(tally) for kind, tally in goals._asdict().items()}


def _counts(value: Confusion | Mapping[str, Confusion]) -> Json:
    if isinstance(value, Confusion):
        return list(value)
    return {key: list(confusion) for key, confusion in value.items()}


def _operator(report: OperatorReport) -> Json:
    return {
        "name": report.name,
        "status": report.status.value,
        "precondition": _side(report.precondition),
        "effect": _side(report.effect),
        "offences": [
            {"offence": finding.offence.value, "name": finding.name, "place": finding.place}
            for finding in report.findings
        ],
    }


def _side(side: SideMatch) -> Json:
    return {
        "matched": list(side.matched),
        "additional": list(side.additional),
        "missing": list(side.missing),
    }
