"""Scorers of the answers to one task: one reading of an answer gives its verdict and the words for it.

`error_report` takes what ended an answer from the engine's terms to those of verdicts, for every ability
alike.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from eai.abilities.explanation import Explanation
from eai.abilities.verdict import ErrorReport, Verdict
from eai.world.domain import Domain
from eai.world.execution import Action, Fault, names_of
from eai.world.state import Scene

if TYPE_CHECKING:
    from eai.abilities.goal_test import GoalTest
    from eai.abilities.notation.plans import CarryOut, PlanNotation, WrittenPlan
    from eai.abilities.task import Task


class Assessment(NamedTuple):
    """The assessment of one answer.

    Attributes:
        verdict: the verdict.
        explain: what became of the answer, in words; they are found when they are asked for.
        look_back: the verdict with what a search of so many states shows besides; None if nothing.
    """

    verdict: Verdict
    explain: Callable[[], Explanation]
    look_back: Callable[[int], Verdict] | None = None


class Scorer(ABC):
    """A scorer of the answers to one task; all it says are pure functions of the answer."""

    @abstractmethod
    def assess(self, text: str) -> Assessment:
        """The verdict on an answer with its explanation, for little more than the verdict alone."""

    def score(self, text: str) -> Verdict:
        """The verdict on an answer."""
        return self.assess(text).verdict

    def unanswered(self) -> Verdict:
        """The verdict where there is no answer: nothing is reached, all is missed, and no error is counted.

        A task that is left out of all statistics whatever the answer is left out here too.
        """
        return self.score("").without_answer()

    def why_excluded(self) -> str | None:
        """Why the task is left out of all statistics whatever the answer; None if it is not."""
        return self.score("").excluded

    def explain(self, text: str) -> Explanation:
        """The explanation of an answer, in words."""
        return self.assess(text).explain()


class PlanScorer(Scorer):
    """A scorer of plans, which can be carried out in another world than the task's own at its beginning.

    Attributes:
        task: the task.
        domain: the world in which plans are executed.
        notation: how plans are written.
        goals: what tests the goals of the task.
    """

    task: Task
    domain: Domain
    notation: PlanNotation
    goals: GoalTest

    @abstractmethod
    def assess_course(self, text: str, carry_out: CarryOut) -> Assessment:
        """The verdict on a plan; its explanation executes also what an excluded task leaves out.

        Args:
            text: the answer.
            carry_out: how the plan is carried out; asked at most once for the verdict.
        """

    @abstractmethod
    def resolve(self, plan: WrittenPlan) -> tuple[Action, ...] | ErrorReport:
        """The plan as ground actions, or its first grammar error: of all names before of any arity."""

    @abstractmethod
    def nearness(self, text: str) -> float | None:
        """How near a plan is to success, from 0 to 1; 0 if it cannot be read.

        Raises:
            InputError: plans are carried out, or goals tested, as another protocol has it.
        """


UNKNOWN_ACTION = "unknown_action"
"""The test of names that an action which does not exist fails; the others are those of `MisuseKind`."""


def error_report(fault: Fault, number: int, domain: Domain, action: Action, scene: Scene) -> ErrorReport:
    """The report on the fault that an action has; ``number`` is that of the step or subgoal."""
    check, names = fault.check, names_of(action, domain, scene)
    objects = tuple([names[parameter] for parameter in check.concerned])
    return ErrorReport(fault.kind, number, check.reason.format_map(names), check.id, objects)
