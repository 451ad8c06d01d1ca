"""What a search says of an answer, in the terms of verdicts: the same for every domain."""

from __future__ import annotations

from eai.abilities.error_report import error_report
from eai.abilities.subgoal_decomposition.branch import Branch
from eai.abilities.subgoal_decomposition.search import Outcome
from eai.abilities.subgoal_decomposition.verdict import SubgoalCategory
from eai.abilities.verdict import ErrorReport
from eai.logic.traversal import objects
from eai.world.domain import Domain
from eai.world.state import Scene


def category_of(outcome: Outcome) -> SubgoalCategory:
    """The category of an answer that could be carried out."""
    if outcome.success:
        return SubgoalCategory.CORRECT
    return SubgoalCategory.GOAL_UNREACHABLE if outcome.executable else SubgoalCategory.RUNTIME


def error_of(branch: Branch, domain: Domain, scene: Scene) -> ErrorReport | None:
    """What ended a branch, if anything did; the step is the number of the subgoal, from 0."""
    failure = branch.failure
    if failure is None:
        return None
    last = branch.tried
    if last is not None and last.step.fault is failure:
        return error_report(failure, branch.subgoal, domain, last.step.action, scene)
    check = failure.check
    return ErrorReport(failure.kind, branch.subgoal, check.reason, check.id, objects(check.condition))
