"""Find plans for tasks by a search in the declared domain, as the built-in model `eai/planner` does."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.planning.planner import Planner, PlanningGoal
from eai.planning.possible import find_unreachable_goals
from eai.planning.search import Limits, SearchEndReason, SearchResult
from eai.tasks.goal_test import list_actions_that_meet_goal
from eai.tasks.task import GoalKind, Task
from eai.world.action import Action
from eai.world.domain import Domain

FindPlan: TypeAlias = "Callable[[Task, Planner, Limits | None], SearchResult[Action]]"
"""Function that searches for a plan for a task: `find_plan`, or a function that caches its results."""


def to_planning_goal(task: Task) -> PlanningGoal:
    """Return a task's goals for the planner: conditions on the final state, and action goals in their order.

    The planner does not support goals over time (about the whole execution), so the result omits them.
    """
    task = task.without_goals_over_time
    return PlanningGoal(
        conditions=tuple(goal.formula for goal in task.goals if goal.kind is not GoalKind.ACTION),
        actions=tuple(map(list_actions_that_meet_goal, task.get_goals_of_kind(GoalKind.ACTION))),
    )


def find_plan(task: Task, planner: Planner, limits: Limits | None = None) -> SearchResult[Action]:
    """Search for a plan that reaches all goals of a task and uses only objects that answers may name."""
    return planner.find_plan(task.initial, to_planning_goal(task), task.planning_object_indices, limits)


def explain_missing_plan(end: SearchEndReason) -> str:
    """Return the reason why a search found no plan, or an empty text if it found a plan."""
    match end:
        case SearchEndReason.SOLVED:
            return ""
        case SearchEndReason.UNREACHABLE:
            return "no plan exists"
        case SearchEndReason.STATES:
            return "no plan was found within the limits of the search"


def is_impossible(task: Task, domain: Domain) -> bool:
    """Whether it is proved that no plan reaches the task's goals about the final state."""
    conditions = to_planning_goal(task).conditions
    return bool(find_unreachable_goals(domain, task.initial, task.planning_object_indices, conditions))
