"""Planners behind one interface: the built-in search, alone or with an authority behind it.

A planner never fails silently: every call ends in one of the outcomes of `PlannerOutcome`, and every plan
is executed by `execute.Executor` before it counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from eai.pddl.evaluation import DerivedPredicates
from eai.pddl.execute import Executor, PlanStep
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask
from eai.pddl.relevance import without_idle_quantifiers
from eai.pddl.search import search
from eai.planning.search import Effort, Limits, SearchEnd

_LOOKS = 300_000
"""How many objects the quantifiers of a plan may look at; a plan of the gold operators looks at hundreds."""


@dataclass(frozen=True, slots=True)
class BuiltInPlanner:
    """The search of this package, alone. What exceeds its effort is `PlannerOutcome.TIME`."""

    limits: Limits = field(default_factory=Limits)

    @property
    def name(self) -> str:
        """What it is called in records."""
        return "built-in search"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan; what it cannot ground is `PlannerOutcome.UNSUPPORTED`."""
        if task.fatal is not None:
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail="an effect adds an unbound variable")
        if DerivedPredicates(task.domain.axioms).circles:
            detail = "a derived predicate depends on itself"
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail=detail)
        task = without_idle_quantifiers(task)
        result = search(task.domain, task.problem, self.limits)
        match result.end:
            case SearchEnd.SOLVED:
                return checked_plan(task, result.plan, self.name)
            case SearchEnd.UNREACHABLE:
                return PlannerResult(PlannerOutcome.UNSOLVABLE, detail=self.name)
            case SearchEnd.STATES:
                looked = f"{result.states} states evaluated" if result.states else "too large a search"
                return PlannerResult(PlannerOutcome.TIME, detail=looked)


@dataclass(frozen=True, slots=True)
class TieredPlanner:
    """Asks a cheap planner first and an authority about what the first cannot decide."""

    first: PddlPlanner
    authority: PddlPlanner

    @property
    def name(self) -> str:
        """What both are called."""
        return f"{self.first.name}, then {self.authority.name}"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        result = self.first.solve(task)
        decided = result.outcome in {PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE}
        return result if decided else self.authority.solve(task)


def checked_plan(task: PlanningTask, plan: Sequence[PlanStep], source: str) -> PlannerResult:
    """The result of a planner that claims to have found a plan, after executing it."""
    looks = Effort(_LOOKS)
    flaw = Executor(task.domain, task.problem, looks).flaw(plan)
    if looks.is_exceeded:
        return PlannerResult(PlannerOutcome.TIME, detail=f"{source}: its plan takes too long to execute")
    if flaw is None:
        return PlannerResult(PlannerOutcome.SOLVED, tuple(plan), source)
    return PlannerResult(
        PlannerOutcome.CRASH, detail=f"{source}: step {flaw.step} of its plan: {flaw.reason}"
    )
