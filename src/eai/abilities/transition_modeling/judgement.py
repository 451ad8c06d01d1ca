"""The judgement of rules on an answer: operators compared, and what a planner can do with them.

`plan_flaw` says whether a plan that was found with an answer's operators works with the gold ones.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Protocol

from eai.abilities.transition_modeling.declaration import OperatorReport
from eai.abilities.transition_modeling.extraction import Memory
from eai.abilities.transition_modeling.task import TransitionTask
from eai.abilities.verdict import Confusion, ErrorReport
from eai.pddl.execute import Executor, PlanFlaw, PlanStep
from eai.pddl.model import PddlAction
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask
from eai.world.fault import FaultKind


def plan_flaw(
    task: TransitionTask, written: Mapping[str, PddlAction], plan: Sequence[PlanStep]
) -> PlanFlaw | None:
    """Why the gold operators cannot execute a plan from the start of the task to its goal; None if they can.

    Each parameter of a gold operator stands for the object that the step has for the parameter of that name;
    where the answer does not use all of the names, parameters correspond by position, and a step with
    another number of objects cannot be executed.

    Args:
        task: the task, which asks for the operators of the plan.
        written: the answer's operators by name.
        plan: the plan.
    """
    domain = replace(task.domain.header, actions=tuple(task.gold.values()))
    steps = [_gold_step(step, written[step.action], task.gold[step.action]) for step in plan]
    return Executor(domain, task.problem).flaw(steps)


def _gold_step(step: PlanStep, written: PddlAction, gold: PddlAction) -> PlanStep:
    """A step as the gold operator takes it."""
    objects = {
        parameter.name: name for parameter, name in zip(written.parameters, step.arguments, strict=True)
    }
    wanted = [parameter.name for parameter in gold.parameters]
    known = objects.keys() >= set(wanted)
    return PlanStep(gold.name, tuple([objects[name] for name in wanted]) if known else step.arguments)


NOT_RUN = PlannerResult(PlannerOutcome.NOT_RUN)
"""The result where no planner is asked."""

NO_OPERATORS = PlannerResult(PlannerOutcome.INPUT_ERROR, detail="the answer holds no operator")
"""The result where there is nothing to plan with."""

UNREADABLE = ErrorReport(
    FaultKind.PARSING, None, 'expected JSON with a text under "output", or operators (:action ...)'
)
"""The error of an answer in which no operator is found."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """The operators of an answer compared with the gold ones, and what a planner can do with them.

    Attributes:
        operators: those that are asked for or written.
        literals: literals matched, additional and missing, by side; None where the rules do not count them.
        planning: what the planner made of them.
        plan_works: whether its plan works with the gold operators; None where the rules do not ask.
        plan_flaw: why it does not; None if it does, or there is no plan.
        repairs: the names of the repairs that reading made.
        repaired: those of them that were made of single operators, by operator.
        renamed: the parameters that stand for gold ones of another name, with that name, by operator.
        error: why nothing could be read, or None.
        excluded: why the answer is left out of all statistics, or None.
    """

    operators: tuple[OperatorReport, ...]
    planning: PlannerResult
    plan_works: bool | None = None
    plan_flaw: PlanFlaw | None = None
    literals: Mapping[str, Confusion] | None = None
    repairs: tuple[str, ...] = ()
    repaired: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    renamed: Mapping[str, tuple[tuple[str, str], ...]] = field(default_factory=dict)
    error: ErrorReport | None = None
    excluded: str | None = None


@dataclass(frozen=True, slots=True)
class PlanMemory:
    """A planner, or none, that remembers what it was asked.

    Answers to one problem are often the same operators in other words or the same words; a key is the
    content of domain and problem.
    """

    planner: PddlPlanner | None
    results: Memory[Hashable, PlannerResult] = field(default_factory=Memory)

    @property
    def without_operators(self) -> PlannerResult:
        """The judgement on an answer without operators."""
        return NOT_RUN if self.planner is None else NO_OPERATORS

    def solve(
        self, key: Hashable, size: int, make: Callable[[], PlanningTask | PlannerResult]
    ) -> PlannerResult:
        """The remembered result for a key, or that of what ``make`` makes: a task, or a foregone result.

        Args:
            key: the content of domain and problem.
            size: how many characters its operators take.
            make: makes what is to be solved.
        """
        planner = self.planner
        if planner is None:
            return NOT_RUN
        return self.results.recall(key, size, lambda: _solved(planner, make()))


def _solved(planner: PddlPlanner, task: PlanningTask | PlannerResult) -> PlannerResult:
    return task if isinstance(task, PlannerResult) else planner.solve(task)


class Replaced(str, Enum):
    """The part of a gold operator that the answer's replaces, where one operator is tried among gold ones.

    With one side alone the parameters stay the gold ones, so that an answer that calls them otherwise has
    unbound variables.
    """

    OPERATOR = "operator"
    PRECONDITION = "precondition"
    EFFECT = "effect"


class Rules(Protocol):
    """How answers are read, compared and planned with."""

    @property
    def plans(self) -> PlanMemory:
        """The planner that judges operators."""
        ...

    @property
    def counts_clauses(self) -> bool:
        """Whether operators are compared clause by clause; else what is compared are predicates."""
        ...

    def plan_one_at_a_time(
        self, task: TransitionTask, text: str, replaced: Replaced
    ) -> dict[str, PlannerResult | None]:
        """The result of each operator that is asked for among gold operators, by name.

        An operator that the answer does not have has none. Empty for an answer that the rules leave out.
        """
        ...

    def judge(self, task: TransitionTask, text: str) -> Judgement:
        """The judgement on an answer, also on one that cannot be read."""
        ...

    def unanswered(self, task: TransitionTask) -> Judgement:
        """The judgement where there is no answer: every operator that is asked for is missing."""
        ...
