"""The verdict on operators: how the operators of an answer compare with the gold operators."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

from eai.abilities.verdict import ALL, NO_COUNTS, Confusion, Credit, Verdict, add_confusions, credit_parts
from eai.base.json_value import Json
from eai.pddl.check import Offence, PddlFinding
from eai.pddl.matching import NO_MATCH, SideMatch, predicates_in
from eai.pddl.planning import PlannerOutcome
from eai.tasks.task import Category
from eai.world.fault import FaultKind


class OperatorStatus(str, Enum):
    """The fate of one operator."""

    COMPARED = "compared"
    MISSING = "missing"
    """Asked for, and not in the answer."""
    UNREADABLE = "unreadable"
    """In the answer, but its text is not PDDL."""
    HALLUCINATED = "hallucinated"
    """In the answer, and not asked for."""


@dataclass(frozen=True, slots=True)
class OperatorReport:
    """One operator that is asked for or written.

    Attributes:
        precondition: clauses matched, additional and missing in the precondition; or predicates, if the
            rules count those.
        effect: the same for the effect.
        offences: what is wrong with it, whatever the gold operator.
    """

    name: str
    status: OperatorStatus
    precondition: SideMatch = NO_MATCH
    effect: SideMatch = NO_MATCH
    offences: tuple[PddlFinding, ...] = ()


OTHER = "other"
"""The category of predicates that the domain does not have."""


class ClauseContent(NamedTuple):
    """The subject of a clause.

    Attributes:
        predicates: those in it, by name.
        categories: those of its predicates, each once; `OTHER` of predicates that have none.
    """

    predicates: tuple[str, ...]
    categories: tuple[str, ...]


def clause_content(clause: str, categories: Mapping[str, Category]) -> ClauseContent:
    """The subject of a clause, which is written as PDDL or is a predicate's name."""
    names = sorted(predicates_in(clause))
    kinds = [categories[name].value if name in categories else OTHER for name in names]
    return ClauseContent(tuple(names), tuple(dict.fromkeys(kinds)))


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """The verdict on operators.

    Attributes:
        success: whether the plan that a planner finds with them works with the gold operators or, under rules
            that do not ask for that, whether it finds one; None if no planner was asked.
        counts: clauses matched, additional and missing, by side (precondition, effect) and category; or
            predicates, if the rules count those.
        literals: the same in literals, by side: partial credit for clauses of which a part is right; None if
            the rules do not give it.
        planner: what the planner made of them.
        plan_works: whether the planner found a plan that works with the gold operators; None if none was
            asked, or under rules that do not ask for that.
        task_categories: the task's own categories, the first the more telling one.
        operators: what comparing each operator with the gold one found out.
        plan: the steps of the plan that was found.
        planner_detail: what else the planner says.
        planner_name: which planner was asked, with its version; None if none was.
        clauses: what each clause of the operators' sides speaks of, by its text.
    """

    success: bool | None = None
    counts: Mapping[str, Mapping[str, Confusion]] | None = None
    literals: Mapping[str, Confusion] | None = None
    planner: PlannerOutcome | None = None
    plan_works: bool | None = None
    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""
    planner_name: str | None = None
    clauses: Mapping[str, ClauseContent] = field(default_factory=dict, compare=False)

    @property
    def columns(self) -> Mapping[str, Json]:
        """The outcome of planning with the operators, and the categories of the task."""
        planner = None if self.planner is None else self.planner.value
        return {"planner": planner, "task_categories": " ".join(self.task_categories)}

    @property
    def planner_used(self) -> str | None:
        """The planner."""
        return self.planner_name

    @property
    def second_planner_outcome(self) -> str | None:
        """The outcome of the authority, where the built-in search did not decide."""
        _, then, authority = (self.planner_name or "").partition(", then ")
        decided = not then or not self.planner_detail.startswith(authority)
        return None if decided or self.planner is None else self.planner.value

    def credit(self, at_start: Sequence[bool]) -> Credit | None:
        """By F1 of all clauses of both sides."""
        return credit_parts(overall_counts(counts_by_category(self)), self.error, self._faults())

    def _faults(self) -> Counter[FaultKind]:
        """Operators that cannot be read or were not asked for, and what is wrong with the others."""
        faults = Counter([_STATUS_FAULTS[r.status] for r in self.operators if r.status in _STATUS_FAULTS])
        for report in self.operators:
            if report.status is OperatorStatus.COMPARED:
                faults.update([_OFFENCE_FAULTS.get(f.offence, FaultKind.PARSING) for f in report.offences])
        return faults


_STATUS_FAULTS = {
    OperatorStatus.UNREADABLE: FaultKind.PARSING,
    OperatorStatus.HALLUCINATED: FaultKind.HALLUCINATION,
}


_OFFENCE_FAULTS = {
    Offence.UNKNOWN_PREDICATE: FaultKind.HALLUCINATION,
    Offence.UNKNOWN_TYPE: FaultKind.HALLUCINATION,
    Offence.UNBOUND_VARIABLE: FaultKind.HALLUCINATION,
    Offence.UNDECLARED_CONSTANT: FaultKind.HALLUCINATION,
    Offence.WRONG_ARITY: FaultKind.ARGUMENT_NUMBER,
    Offence.WRONG_ARGUMENT_TYPE: FaultKind.AFFORDANCE,
}
"""The kind of an operator's offence in the taxonomy of plans; any other is one of writing."""


def counts_by_category(verdict: OperatorVerdict) -> dict[str, Confusion]:
    """Return the counts of both sides, by category."""
    found: dict[str, Confusion] = {}
    for side in (verdict.counts or {}).values():
        for name, confusion in side.items():
            found[name] = add_confusions((found.get(name, NO_COUNTS), confusion))
    return found


def overall_counts(counts: Mapping[str, Confusion]) -> Confusion:
    """Return the counts of both sides over all categories. A clause of several categories counts once."""
    return counts.get(ALL) or add_confusions(counts.values())
