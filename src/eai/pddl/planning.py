"""Planning tasks and what planners make of them: the interface between scoring and planners.

A planner never fails silently: every call ends in one of the outcomes of `PlannerOutcome`, and every plan
is executed by `execute.Executor` before it counts.
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
"""How many objects the quantifiers of a plan may look at; a plan of the gold operators looks at hundreds."""


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


class PlannerChoice(str, Enum):
    """Which planner judges operators."""

    AUTO = "auto"
    """``full`` where Fast Downward is installed, else ``built_in``."""
    FULL = "full"
    """The built-in search, and Fast Downward for what it cannot decide."""
    BUILT_IN = "built_in"
    """The built-in search alone; what it cannot decide counts as not solved."""
    FAST_DOWNWARD = "fast_downward"
    NONE = "none"


@dataclass(frozen=True, slots=True)
class PlannerTerms:
    """On what terms planners are asked, where the benchmark's are not to count.

    Attributes:
        seconds: CPU seconds of each process of a call; the benchmark's if None.
        memory_mib: what all planners together may use at a time; what there is if None.
        folder: where processes that plan together share seats (`eai.pddl.fast_downward`); None where none do.
    """

    seconds: int | None = None
    memory_mib: int | None = None
    folder: Path | None = None


@dataclass(frozen=True, slots=True)
class PlannerResult:
    """The outcome, the plan if there is one, and in words what the outcome rests on."""

    outcome: PlannerOutcome
    plan: tuple[PlanStep, ...] = ()
    detail: str = ""


@dataclass(frozen=True, slots=True)
class PlanningTask:
    """The task of a planner.

    ``fatal`` is an atom whose mere reachability counts as a crash of the planner; it stands for additions
    of atoms with unbound variables (`scope`).
    """

    domain: PddlDomain
    problem: PddlProblem
    fatal: Atom | None = None


def refuse_task(finding: PddlFinding) -> PlannerResult:
    """The result of a task that no planner needs to see, for the offence that makes it unacceptable."""
    detail = f"{finding.place}: {finding.offence.value}: {finding.words}"
    return PlannerResult(PlannerOutcome.INPUT_ERROR, detail=detail)


class PddlPlanner(Protocol):
    """Anything that solves planning tasks; the same task always has the same result, resources permitting."""

    @property
    def name(self) -> str:
        """Its name in records: with its version, for that decides the numbers."""
        ...

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        ...


def check_plan(task: PlanningTask, plan: Sequence[PlanStep], source: str) -> PlannerResult:
    """The result of a planner that claims to have found a plan, after executing it."""
    from eai.pddl.execute import Executor
    from eai.planning.search import Effort

    looks = Effort(_MAX_LOOKS)
    flaw = Executor(task.domain, task.problem, looks).find_flaw(plan)
    if looks.is_exceeded:
        return PlannerResult(PlannerOutcome.TIME, detail=f"{source}: its plan takes too long to execute")
    if flaw is None:
        return PlannerResult(PlannerOutcome.SOLVED, tuple(plan), source)
    step, reason = flaw
    return PlannerResult(PlannerOutcome.CRASH, detail=f"{source}: step {step} of its plan: {reason}")
