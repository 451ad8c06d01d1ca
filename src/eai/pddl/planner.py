"""Planners behind one interface: the built-in search, alone or with an authority behind it.

A planner never fails silently: every call ends in one of the outcomes of `PlannerOutcome`, and every plan
is executed by `execute.Executor` before it counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from eai.logic.formula import Atom
from eai.pddl.execute import Executor, Step
from eai.pddl.model import Domain, Problem
from eai.pddl.search import Effort, SearchVerdict, search


class PlannerOutcome(str, Enum):
    """How a planner call ended. The values are the wire strings."""

    SOLVED = "solved"
    UNSOLVABLE = "unsolvable"
    """There is no plan, or the planner's search space holds none."""
    INPUT_ERROR = "input_error"
    """The domain or problem is not acceptable PDDL."""
    UNSUPPORTED = "unsupported"
    TIME = "time"
    """The limit of CPU time, or of evaluated states, was reached."""
    MEMORY = "memory"
    CRASH = "crash"
    NOT_RUN = "not_run"


@dataclass(frozen=True, slots=True)
class PlannerResult:
    """The outcome, the plan if there is one, and in words what the outcome rests on."""

    outcome: PlannerOutcome
    plan: tuple[Step, ...] = ()
    detail: str = ""


@dataclass(frozen=True, slots=True)
class PlanningTask:
    """What a planner is given.

    ``fatal`` is an atom whose mere reachability counts as a crash of the planner; it stands for additions
    of atoms with unbound variables (`scope`).
    """

    domain: Domain
    problem: Problem
    fatal: Atom | None = None


class Planner(Protocol):
    """Anything that solves planning tasks; the same task always has the same result, resources permitting."""

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        ...


@dataclass(frozen=True, slots=True)
class BuiltInPlanner:
    """The search of this package, alone. What exceeds its effort is `PlannerOutcome.TIME`."""

    effort: Effort = field(default_factory=Effort)

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan; a task with a fatal atom is `PlannerOutcome.UNSUPPORTED`."""
        if task.fatal is not None:
            return PlannerResult(PlannerOutcome.UNSUPPORTED, detail="an effect adds an unbound variable")
        result = search(task.domain, task.problem, self.effort)
        match result.verdict:
            case SearchVerdict.SOLVED:
                return checked_plan(task, result.plan, "built-in search")
            case SearchVerdict.UNSOLVABLE:
                return PlannerResult(PlannerOutcome.UNSOLVABLE, detail="built-in search")
            case SearchVerdict.UNDECIDED:
                return PlannerResult(PlannerOutcome.TIME, detail=f"{result.evaluated} states evaluated")


@dataclass(frozen=True, slots=True)
class TieredPlanner:
    """Asks a cheap planner first and an authority about what the first cannot decide."""

    first: Planner
    authority: Planner

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        result = self.first.solve(task)
        decided = result.outcome in {PlannerOutcome.SOLVED, PlannerOutcome.UNSOLVABLE}
        return result if decided else self.authority.solve(task)


class NoPlanner:
    """Does not plan, for runs that only compare operators."""

    def solve(self, task: PlanningTask) -> PlannerResult:
        """`PlannerOutcome.NOT_RUN`, always."""
        del task
        return PlannerResult(PlannerOutcome.NOT_RUN)


def checked_plan(task: PlanningTask, plan: Sequence[Step], source: str) -> PlannerResult:
    """The result of a planner that claims to have found a plan, after executing it."""
    flaw = Executor(task.domain, task.problem).flaw(plan)
    if flaw is None:
        return PlannerResult(PlannerOutcome.SOLVED, tuple(plan), source)
    return PlannerResult(
        PlannerOutcome.CRASH, detail=f"{source}: step {flaw.step} of its plan: {flaw.reason}"
    )
