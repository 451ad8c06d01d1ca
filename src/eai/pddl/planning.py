"""Planning tasks and the results of planners: the interface between scoring and planners.

A planner never fails silently: every call ends in one of the outcomes of `PlannerOutcome`, and every plan is
executed by `execute.PddlPlanExecutor` before it counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from eai.logic.formula import Atom
    from eai.pddl.check import PddlFinding
    from eai.pddl.execute import PlanStep
    from eai.pddl.model import PddlDomain, PddlProblem

_MAX_LOOKS = 300_000
"""Maximum number of objects that quantifiers may visit while a plan is checked.

Plans with gold operators need hundreds.
"""


class PlannerOutcome(str, Enum):
    """The outcome of a planner call. Stored verdicts (records) contain its value."""

    SOLVED = "solved"
    UNSOLVABLE = "unsolvable"
    """There is no plan, or the part of the state space that the planner searches contains no plan."""
    INPUT_ERROR = "input_error"
    """The planner does not accept the domain or problem as PDDL."""
    UNSUPPORTED = "unsupported"
    TIME = "time"
    """The limit of CPU time, or of evaluated states, was reached."""
    MEMORY = "memory"
    CRASH = "crash"
    NOT_RUN = "not_run"


class PlannerChoice(str, Enum):
    """The choice of the planner that judges the operators in answers."""

    AUTO = "auto"
    """``full`` if Fast Downward is installed, else ``built_in``."""
    FULL = "full"
    """The built-in search, then Fast Downward for tasks that the search neither solves nor refutes."""
    BUILT_IN = "built_in"
    """Only the built-in search; tasks that it neither solves nor refutes count as not solved."""
    FAST_DOWNWARD = "fast_downward"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class PlannerLimits:
    """The user's limits of planners, which replace the benchmark's limits.

    Attributes:
        seconds: CPU seconds of each process of a planner call; the benchmark's number if None.
        memory_mib: memory for all planners that run at a time, in MiB; all memory of the machine if None.
        folder: the folder of lock files by which processes limit the number of planner calls at a time
            (`eai.pddl.fast_downward`); None for no limit.
    """

    seconds: int | None = None
    memory_mib: int | None = None
    folder: Path | None = None


@dataclass(frozen=True, slots=True)
class PlannerResult:
    """The outcome of a planner call, the plan if one was found, and the reason for the outcome in words."""

    outcome: PlannerOutcome
    plan: tuple[PlanStep, ...] = ()
    detail: str = ""


@dataclass(frozen=True, slots=True)
class PlanningTask:
    """The task of a planner: a domain and a problem.

    A model's operator may add an atom with an unbound variable, which made the planner of 2024 crash. In the
    domain such an effect adds the atom ``fatal`` instead. If ``fatal`` is reachable, the planner is reported
    to crash (`eai.extensions.reference.planner_of_2024`).
    """

    domain: PddlDomain
    problem: PddlProblem
    fatal: Atom | None = None


def make_input_error_result(finding: PddlFinding) -> PlannerResult:
    """Return the result for a task that violates the rules of PDDL. It needs no planner."""
    detail = f"{finding.place}: {finding.offence.value}: {finding.description}"
    return PlannerResult(PlannerOutcome.INPUT_ERROR, detail=detail)


class PddlPlanner(Protocol):
    """A planner. Equal tasks have equal results if time and memory suffice."""

    @property
    def name(self) -> str:
        """The name of the planner in stored verdicts (records), with its version, which results depend on."""
        ...

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Search for a plan."""
        ...


def execute_found_plan(task: PlanningTask, plan: Sequence[PlanStep], planner_name: str) -> PlannerResult:
    """Return the result of a planner call that found a plan, after executing this plan."""
    from eai.pddl.execute import PddlPlanExecutor
    from eai.planning.search import SearchEffort

    looks = SearchEffort(_MAX_LOOKS)
    flaw = PddlPlanExecutor(task.domain, task.problem, looks).find_failed_step(plan)
    if looks.is_limit_exceeded:
        return PlannerResult(
            PlannerOutcome.TIME, detail=f"{planner_name}: its plan takes too long to execute"
        )
    if flaw is None:
        return PlannerResult(PlannerOutcome.SOLVED, tuple(plan), planner_name)
    step, reason = flaw
    return PlannerResult(PlannerOutcome.CRASH, detail=f"{planner_name}: step {step} of its plan: {reason}")
