"""Scorers of the answers to one task: one reading of an answer gives its verdict and the words for it.

`error_report` takes what ended an answer from the engine's terms to those of verdicts, for every ability
alike. `assess_or_fail` fails an answer whose scorer raises an exception, so that other answers are scored.
"""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import PurePath
from traceback import extract_tb
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from eai.abilities.explanation import Explanation
from eai.abilities.verdict import RAISED, ErrorReport, Unreadable, Verdict
from eai.base.errors import EaiError, InputError
from eai.tasks.task import TaskExclusion
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import argument_names
from eai.world.fault import FaultKind
from eai.world.state import Scene

if TYPE_CHECKING:
    from eai.abilities.notation.plan_form import WrittenPlan
    from eai.abilities.notation.plans import CarryOut, PlanNotation
    from eai.tasks.goal_test import GoalTest
    from eai.tasks.task import Task


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

    def why_excluded(self) -> TaskExclusion | None:
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
    def read(self, text: str) -> WrittenPlan | Unreadable:
        """Read the plan in an answer as it is scored, or say why it cannot be read as a whole."""

    @abstractmethod
    def resolve(self, plan: WrittenPlan) -> tuple[Action, ...] | ErrorReport:
        """The plan as ground actions, or its first grammar error: of all names before of any arity."""

    @abstractmethod
    def nearness(self, text: str) -> float | None:
        """How near a plan is to success, from 0 to 1; 0 if it cannot be read.

        Raises:
            InputError: plans are carried out, or goals tested, as another protocol has it.
        """


_LOG = logging.getLogger(__name__)

_MAX_MESSAGE = 200
"""Largest number of characters of an exception's message in a verdict."""

R = TypeVar("R")


def assess_or_fail(scorer: Scorer, empty: Verdict, assess: Callable[[], Assessment]) -> Assessment:
    """Return an assessment. If the scorer raises an exception, the answer fails as one that reaches nothing.

    Exceptions that are not about the answer pass: missing data, missing packages and interrupts.

    Args:
        scorer: the scorer.
        empty: a verdict of the ability's class without content, for a scorer that always raises.
        assess: assesses the answer.
    """
    try:
        verdict, explain, look_back = assess()
    except Exception as error:
        if _is_of_surroundings(error):
            raise
        return _failed(scorer, empty, error)
    looked_back = None if look_back is None else partial(_or_else, look_back, verdict)
    return Assessment(verdict, partial(_or_else, explain, Explanation()), looked_back)


def exception_text(error: Exception) -> str:
    """Return the type, the place and the message of an exception."""
    *_, frame = extract_tb(error.__traceback__)
    place = f"{PurePath(frame.filename).name}:{frame.lineno}"
    message = " ".join(str(error).split())[:_MAX_MESSAGE]
    return f"{type(error).__name__} ({place}){': ' if message else ''}{message}"


def _is_of_surroundings(error: Exception) -> bool:
    return isinstance(error, EaiError) and not isinstance(error, InputError)


def _failed(scorer: Scorer, empty: Verdict, error: Exception) -> Assessment:
    try:
        verdict = scorer.unanswered()
    except Exception:  # it raises whatever the answer
        verdict = empty.without_answer()
    reason = f"the scorer raised {exception_text(error)}"
    if verdict.excluded is None:
        verdict = replace(verdict, error=ErrorReport(FaultKind.UNCATEGORISED, None, reason, RAISED))
    return Assessment(verdict, lambda: Explanation((reason,)))


def _or_else(compute: Callable[..., R], default: R, *arguments: int) -> R:
    """Return a result, or a default and a warning if computing it raises: the verdict stands without it."""
    try:
        return compute(*arguments)
    except Exception as error:
        if _is_of_surroundings(error):
            raise
        _LOG.warning("a verdict lacks its explanation: %s", exception_text(error))
        return default


def error_report(fault: Fault, number: int, domain: Domain, action: Action, scene: Scene) -> ErrorReport:
    """The report on the fault that an action has; ``number`` is that of the step or subgoal."""
    check, names = fault.check, argument_names(action, domain, scene)
    objects = tuple([names[parameter] for parameter in check.mentioned_parameters])
    return ErrorReport(fault.kind, number, check.reason.format_map(names), check.id, objects)
