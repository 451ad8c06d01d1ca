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
