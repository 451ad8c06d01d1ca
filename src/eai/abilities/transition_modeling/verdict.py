"""The verdict on the operators of an answer, which compares them with the gold operators."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from eai.abilities.verdict import (
    ALL,
    NO_COUNTS,
    ConfusionCounts,
    RewardInputs,
    Verdict,
    compute_reward_inputs_from_part_counts,
    sum_confusion_counts,
)
from eai.base.json_value import Json
from eai.pddl.check import PddlFinding, PddlViolationKind
from eai.pddl.matching import NO_MATCH, ClauseComparison, find_predicates_in_text
from eai.pddl.planning import PlannerOutcome
from eai.tasks.task import PredicateCategory
from eai.world.fault import FaultKind


class OperatorComparisonStatus(str, Enum):
    """Whether an operator was compared with the gold operator, or why it was not."""

    COMPARED = "compared"
    MISSING = "missing"
    """The task asks for the operator, but the answer does not have it."""
    UNREADABLE = "unreadable"
    """The answer has the operator, but its text is not PDDL."""
    HALLUCINATED = "hallucinated"
    """The answer has the operator, but the task does not ask for it."""


@dataclass(frozen=True, slots=True)
class OperatorReport:
    """The report on one operator of the task or the answer.

    Attributes:
        name: name of the operator.
        status: whether the operator was compared, and otherwise the reason.
        precondition: matched, additional and missing clauses of the precondition; the predicates in them, if
            the rules count predicates.
        effect: matched, additional and missing clauses (or predicates) of the effect.
        offences: defects of the operator that do not depend on the gold operator.
    """

    name: str
    status: OperatorComparisonStatus
    precondition: ClauseComparison = NO_MATCH
    effect: ClauseComparison = NO_MATCH
    offences: tuple[PddlFinding, ...] = ()


OTHER = "other"
"""Category of predicates that do not exist in the domain."""


class PredicatesInClause(NamedTuple):
    """The predicates of a clause.

    Attributes:
        predicates: names of the predicates in the clause.
        categories: categories of the predicates, each once; `OTHER` for unknown predicates.
    """

    predicates: tuple[str, ...]
    categories: tuple[str, ...]


def find_predicates_and_their_categories(
    clause: str, categories: Mapping[str, PredicateCategory]
) -> PredicatesInClause:
    """Return the predicates of a clause and their categories.

    The clause is a PDDL text, or only the name of a predicate.
    """
    names = sorted(find_predicates_in_text(clause))
    kinds = [categories[name].value if name in categories else OTHER for name in names]
    return PredicatesInClause(tuple(names), tuple(dict.fromkeys(kinds)))


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """The verdict on the operators of an answer.

    Attributes:
        success: whether the plan found with the operators works with the gold operators. Under rules that do
            not test this, whether a plan was found. None if no planner was used.
        counts: mapping from side (precondition, effect) and category to the numbers of matched, additional
            and missing clauses; numbers of predicates, if the rules count predicates.
        literals: mapping from side to the numbers of matched, additional and missing literals, which give
            partial credit for partly right clauses; None if the rules do not count literals.
        planner: outcome of planning with the operators.
        plan_works: whether the planner found a plan that works with the gold operators; None if no planner
            was used, or under rules that do not test this.
        task_categories: categories of the task; the more informative category comes first.
        operators: comparison of each operator with its gold operator.
        plan: steps of the plan that was found.
        planner_detail: further remarks of the planner.
        planner_name: name and version of the planner; None if no planner was used.
        clauses: mapping from the text of each clause in the operators to the clause's predicates.
    """

    success: bool | None = None
    counts: Mapping[str, Mapping[str, ConfusionCounts]] | None = None
    literals: Mapping[str, ConfusionCounts] | None = None
    planner: PlannerOutcome | None = None
    plan_works: bool | None = None
    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""
    planner_name: str | None = None
    clauses: Mapping[str, PredicatesInClause] = field(default_factory=dict, compare=False)

    @property
    def values_by_column(self) -> Mapping[str, Json]:
        """Mapping from table columns to values: the outcome of planning, and the categories of the task."""
        planner = None if self.planner is None else self.planner.value
        return {"planner": planner, "task_categories": " ".join(self.task_categories)}

    @property
    def name_of_used_planner(self) -> str | None:
        """Name of the planner that judged the answer; None if no planner was used."""
        return self.planner_name

    @property
    def outcome_of_fallback_planner(self) -> str | None:
        """Outcome of the planner that ran after the built-in search; None if that search gave the result."""
        _, then, authority = (self.planner_name or "").partition(", then ")
        decided = not then or not self.planner_detail.startswith(authority)
        return None if decided or self.planner is None else self.planner.value

    def compute_reward_inputs(self, goals_at_start: Sequence[bool]) -> RewardInputs | None:
        """Return the inputs of the reward, or None if the required operators have no clauses.

        The gain (`RewardInputs.gain`) is the F1 of all clauses in preconditions and effects.
        """
        return compute_reward_inputs_from_part_counts(
            sum_counts_of_categories(count_clauses_by_category(self)), self.error, self._count_faults()
        )

    def _count_faults(self) -> Counter[FaultKind]:
        """Return the number of faults by kind: unreadable and hallucinated operators, and other defects."""
        faults = Counter([_STATUS_FAULTS[r.status] for r in self.operators if r.status in _STATUS_FAULTS])
        for report in self.operators:
            if report.status is OperatorComparisonStatus.COMPARED:
                faults.update(
                    [_FAULT_BY_VIOLATION.get(f.offence, FaultKind.PARSING) for f in report.offences]
                )
        return faults


_STATUS_FAULTS = {
    OperatorComparisonStatus.UNREADABLE: FaultKind.PARSING,
    OperatorComparisonStatus.HALLUCINATED: FaultKind.HALLUCINATION,
}


_FAULT_BY_VIOLATION = {
    PddlViolationKind.UNKNOWN_PREDICATE: FaultKind.HALLUCINATION,
    PddlViolationKind.UNKNOWN_TYPE: FaultKind.HALLUCINATION,
    PddlViolationKind.UNBOUND_VARIABLE: FaultKind.HALLUCINATION,
    PddlViolationKind.UNDECLARED_CONSTANT: FaultKind.HALLUCINATION,
    PddlViolationKind.WRONG_ARITY: FaultKind.ARGUMENT_NUMBER,
    PddlViolationKind.WRONG_ARGUMENT_TYPE: FaultKind.AFFORDANCE,
}
"""Mapping from the kind of a violation in an operator's PDDL to the kind of fault.

All other violations are parsing errors.
"""


def count_clauses_by_category(verdict: OperatorVerdict) -> dict[str, ConfusionCounts]:
    """Return a mapping from categories to the numbers of right, wrong and missed clauses.

    Preconditions and effects are counted together. Scoring rules whose `OperatorScoringRules.counts_clauses`
    is False count predicates instead of clauses.
    """
    counts: dict[str, ConfusionCounts] = {}
    for side in (verdict.counts or {}).values():
        for name, confusion in side.items():
            counts[name] = sum_confusion_counts((counts.get(name, NO_COUNTS), confusion))
    return counts


def sum_counts_of_categories(counts_by_category: Mapping[str, ConfusionCounts]) -> ConfusionCounts:
    """Return the counts of all categories together. A clause that is in several categories counts once."""
    return counts_by_category.get(ALL) or sum_confusion_counts(counts_by_category.values())
