"""What scoring says of operators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from eai.abilities.transition_modeling.report import OperatorReport
from eai.abilities.verdict import Confusion, Verdict
from eai.pddl.planning import PlannerOutcome


@dataclass(frozen=True, slots=True)
class OperatorVerdict(Verdict):
    """What scoring says of operators.

    Attributes:
        success: whether the plan that a planner finds with them works with the gold operators or, under rules
            that do not ask for that, whether it finds one; None if no planner was asked.
        counts: clauses matched, additional and missing, by side (precondition, effect) and category; or
            predicates, if the rules count those.
        literals: the same in literals, by side: partial credit for clauses of which a part is right; None if
            the rules do not give it.
        planner: what the planner made of them.
        plan_works: whether the planner found a plan that works with the gold operators; None if none was
            asked, under rules that do not ask for that, or in older records.
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
    plan_works: bool | None = None
    task_categories: tuple[str, ...] = ()
    operators: tuple[OperatorReport, ...] = ()
    plan: tuple[str, ...] = ()
    planner_detail: str = ""
    planner_name: str | None = None
