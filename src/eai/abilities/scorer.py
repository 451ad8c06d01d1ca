"""Scorers of the answers to one task. A scorer reads an answer once for both its verdict and its explanation.

`make_error_report` turns the fault that ended an answer into the error in its verdict, for all abilities. If
a scorer raises an exception, `assess_or_report_failure` fails the answer, so that all other answers are still
scored.
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

from eai.abilities.explanation import VerdictExplanation
from eai.abilities.verdict import RAISED, ErrorReport, Unreadable, Verdict
from eai.base.errors import EaiError, InputError
from eai.tasks.task import TaskExclusion
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import map_parameters_to_names
from eai.world.fault import FaultKind
from eai.world.state import Scene

if TYPE_CHECKING:
    from eai.abilities.notation.plan_form import WrittenPlan
    from eai.abilities.notation.plans import PlanExecutor, PlanNotation
    from eai.tasks.goal_test import GoalTest
    from eai.tasks.task import Task


class Assessment(NamedTuple):
    """The assessment of one answer.

    Attributes:
        verdict: the verdict.
        explain: returns the explanation in words. Its computation starts only with this call.
        analyze_failure: takes a maximum number of states, and returns the verdict with the results of a
            search, such as a repair; None if the ability has no such analysis.
    """

    verdict: Verdict
    explain: Callable[[], VerdictExplanation]
    analyze_failure: Callable[[int], Verdict] | None = None


class Scorer(ABC):
    """A scorer of the answers to one task. All results are pure functions of the answer."""

    @abstractmethod
    def assess(self, text: str) -> Assessment:
        """Return the verdict on an answer, with an explanation that is computed only on request."""

    def score(self, text: str) -> Verdict:
        """Return the verdict on an answer."""
        return self.assess(text).verdict

    def score_missing_answer(self) -> Verdict:
        """Return the verdict on a missing answer: it misses all goals, and has no error.

        If the task is excluded whatever the answer is, the missing answer is excluded, too.
        """
        return self.score("").to_verdict_on_missing_answer()

    def find_exclusion(self) -> TaskExclusion | None:
        """Return the reason why the task is excluded for all answers, or None if it is scored."""
        return self.score("").excluded

    def explain(self, text: str) -> VerdictExplanation:
        """Return the explanation of an answer, in words."""
        return self.assess(text).explain()


class PlanScorer(Scorer):
    """A scorer of plans. It can also score a plan that is executed in another state than the initial one.

    Attributes:
        task: the task.
        domain: the domain in which plans are executed.
        notation: the notation of plans.
        goals: the test of the task's goals.
    """

    task: Task
    domain: Domain
    notation: PlanNotation
    goals: GoalTest

    @abstractmethod
    def assess_execution(self, text: str, execute: PlanExecutor) -> Assessment:
        """Return the assessment of a plan.

        If the task is excluded from scoring, the plan is executed only when `Assessment.explain` is called.

        Args:
            text: the answer.
            execute: function that executes the plan. It is called at most once.
        """

    @abstractmethod
    def read(self, text: str) -> WrittenPlan | Unreadable:
        """Return the plan in an answer, or the reason why the answer cannot be read."""

    @abstractmethod
    def resolve_names(self, plan: WrittenPlan) -> tuple[Action, ...] | ErrorReport:
        """Return the actions on objects that a plan means, or the first error in its names.

        Unknown names are reported before wrong numbers of arguments.
        """

    @abstractmethod
    def compute_closeness_to_success(self, text: str) -> float | None:
        """Return the closeness of a plan to success, from 0 to 1; 0 if the plan cannot be read.

        Return None if the closeness is unknown, as for tasks with goals about the whole execution.

        Raises:
            InputError: answers are not scored by the paper's rules, which are named ``strict``.
        """


_LOG = logging.getLogger(__name__)

_MAX_MESSAGE_CHARACTERS = 200
"""Maximum number of characters that a verdict quotes from an exception's message."""

R = TypeVar("R")


def assess_or_report_failure(
    scorer: Scorer, empty_verdict: Verdict, assess: Callable[[], Assessment]
) -> Assessment:
    """Return the assessment of an answer.

    If the scorer raises an exception, the answer fails and reaches no goal.

    Exceptions that do not concern the answer are raised again: missing data, missing packages and interrupts.

    Args:
        scorer: the scorer.
        empty_verdict: an empty verdict of the ability's class, used if the scorer raises an exception even
            for a missing answer.
        assess: assesses the answer.
    """
    try:
        verdict, explain, look_back = assess()
    except Exception as error:
        if _is_unrelated_to_answer(error):
            raise
        return _assess_scorer_failure(scorer, empty_verdict, error)
    looked_back = None if look_back is None else partial(_compute_or_default_on_exception, look_back, verdict)
    return Assessment(
        verdict, partial(_compute_or_default_on_exception, explain, VerdictExplanation()), looked_back
    )


def describe_exception(error: Exception) -> str:
    """Return a text with the type of an exception, the file and line of its origin, and its message."""
    *_, frame = extract_tb(error.__traceback__)
    place = f"{PurePath(frame.filename).name}:{frame.lineno}"
    message = " ".join(str(error).split())[:_MAX_MESSAGE_CHARACTERS]
    return f"{type(error).__name__} ({place}){': ' if message else ''}{message}"


def _is_unrelated_to_answer(error: Exception) -> bool:
    return isinstance(error, EaiError) and not isinstance(error, InputError)


def _assess_scorer_failure(scorer: Scorer, empty_verdict: Verdict, error: Exception) -> Assessment:
    try:
        verdict = scorer.score_missing_answer()
    except Exception:  # this scorer fails for missing answers, too
        verdict = empty_verdict.to_verdict_on_missing_answer()
    reason = f"the scorer raised {describe_exception(error)}"
    if verdict.excluded is None:
        verdict = replace(verdict, error=ErrorReport(FaultKind.UNCATEGORISED, None, reason, RAISED))
    return Assessment(verdict, lambda: VerdictExplanation((reason,)))


def _compute_or_default_on_exception(compute: Callable[..., R], default: R, *arguments: int) -> R:
    """Return the result of a function, or a default if the function raises an exception.

    The exception is logged as a warning. So an explanation that fails does not change the verdict.
    """
    try:
        return compute(*arguments)
    except Exception as error:
        if _is_unrelated_to_answer(error):
            raise
        _LOG.warning("a verdict lacks its explanation: %s", describe_exception(error))
        return default


def make_error_report(
    fault: Fault, step_number: int, domain: Domain, action: Action, scene: Scene
) -> ErrorReport:
    """Return the error that a verdict reports for the fault of an action.

    Args:
        fault: the fault.
        step_number: number of the step or subgoal, from 0.
        domain: the domain.
        action: the action.
        scene: the scene.
    """
    check, names = fault.check, map_parameters_to_names(action, domain, scene)
    objects = tuple([names[parameter] for parameter in check.mentioned_parameters])
    return ErrorReport(fault.kind, step_number, check.reason.format_map(names), check.id, objects)
