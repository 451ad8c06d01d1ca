"""Label each step of a plan with the change in the distance to the goals.

The distance of a state is the number of actions in a shortest plan from this state to the goals. It is found
by repairing an empty plan: the smallest repair inserts all actions of a shortest plan. A search that reaches
its limit of effort finds only bounds. If bounds differ, the distance is unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import NamedTuple, TypeAlias

from eai.abilities.explanation import EXECUTED, SLIP
from eai.abilities.plan_repairer import PlanRepairer
from eai.abilities.reports import action_text
from eai.planning.planner import get_planner
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import SearchEffort
from eai.tasks.goal_test import find_remaining_goals
from eai.tasks.planning import to_planning_goal
from eai.tasks.task import Goal
from eai.world.action import Action
from eai.world.domain import make_declared_effects_simulator
from eai.world.execution import Step, execute_plan
from eai.world.state import State

NOT_TRIED = "not_tried"
"""Outcome of a step that was not tried because an earlier step failed."""


_MAX_SUCCESSIVE_UNKNOWN_DISTANCES = 3
"""The computation ends after this number of successive states with unknown distances to the goals.

Distances are computed from the last state to the first, because distances near the goals are easier to prove.
"""


class _DistanceBounds(NamedTuple):
    """The proved minimum and the proved maximum of a distance, in actions."""

    at_least: float
    at_most: float

    @property
    def exact_distance_to_goals(self) -> int | None:
        return int(self.at_least) if self.at_least == self.at_most else None


class _StepWithDistanceToGoals(NamedTuple):
    """The label of one step.

    Attributes:
        step: the action as text.
        outcome: ``executed``, the kind of the fault, or `NOT_TRIED`.
        distance: the number of actions in a shortest plan from the state after the step; None if unknown.
        change: this distance minus the distance before the step: -1 for a step of a shortest plan, 0 for a
            step without effect. None if it is unknown, or the step was not tried.
    """

    step: str
    outcome: str
    distance: int | None
    change: int | None


StepLabeler: TypeAlias = Callable[
    [Sequence[Action]], tuple["int | None", tuple[_StepWithDistanceToGoals, ...]]
]
"""Function from a plan to a pair: the distance of its initial state from the goal, and its labelled steps.

The distance is the number of actions in a shortest plan to the goal, or None if it is unknown.
"""


def make_labeler_of_step_distances_to_goals(repairer: PlanRepairer, max_tried_steps: int) -> StepLabeler:
    """Return a function that labels the steps of plans for one task: with outcomes and distances to the goal.

    Shortest plans may use the objects of the task and of the labelled plan. Distances of states are cached.

    Args:
        repairer: the repairer of plans for the task.
        max_tried_steps: the approximate limit of the effort for each state, as in
            `FewestEditsPlanRepairer.repair`.
    """
    return _StepDistanceMeasurer(repairer, max_tried_steps).measure_distances_to_goal


class _StepDistanceMeasurer:
    def __init__(self, repairer: PlanRepairer, limit: int) -> None:
        self._task, self._domain, self._limit = repairer.task, repairer.domain, limit
        self._has_distances = (
            repairer.why_distance_unknown is None and self._domain.begin is make_declared_effects_simulator
        )
        self._known: dict[tuple[State, tuple[Goal, ...], tuple[int, ...]], _DistanceBounds] = {}

    def measure_distances_to_goal(
        self, actions: Sequence[Action]
    ) -> tuple[int | None, tuple[_StepWithDistanceToGoals, ...]]:
        trajectory = execute_plan(self._domain, self._task.initial, actions)
        named = {index for action in actions for index in action.arguments}
        objects = tuple(dict.fromkeys([*self._task.planning_object_indices, *sorted(named)]))
        executed = [action.operator for action in trajectory.executed_actions]
        bounds, unknown = [_DistanceBounds(0, inf)] * len(trajectory.states), 0
        for number, state in reversed([*enumerate(trajectory.states)]):
            goals = find_remaining_goals(self._task, executed[:number])
            bounds[number] = self._find_distance_bounds(state, goals, objects)
            unknown = 0 if bounds[number].exact_distance_to_goals is not None else unknown + 1
            if unknown == _MAX_SUCCESSIVE_UNKNOWN_DISTANCES:
                break
        distances = [distance.exact_distance_to_goals for distance in _tighten_distance_bounds(bounds)]
        return distances[0], tuple(
            self._label_steps_with_distances_to_goals(actions, trajectory.steps, distances)
        )

    def _label_steps_with_distances_to_goals(
        self, actions: Sequence[Action], tried_steps: Sequence[Step], distances: Sequence[int | None]
    ) -> Iterator[_StepWithDistanceToGoals]:
        number = 0
        for place, action in enumerate(actions):
            text, before = action_text(action, self._task.scene), distances[number]
            if place >= len(tried_steps):
                yield _StepWithDistanceToGoals(text, NOT_TRIED, None, None)
            elif tried_steps[place].is_executed:
                number += 1
                after = distances[number]
                change = None if before is None or after is None else after - before
                yield _StepWithDistanceToGoals(text, EXECUTED, after, change)
            else:
                fault = tried_steps[place].fault
                yield _StepWithDistanceToGoals(text, SLIP if fault is None else fault.kind.value, before, 0)

    def _find_distance_bounds(
        self, state: State, goals: tuple[Goal, ...], objects: tuple[int, ...]
    ) -> _DistanceBounds:
        if not self._has_distances:
            return _DistanceBounds(0, inf)
        key = state, goals, objects
        if key not in self._known:
            goal = to_planning_goal(self._task.replace_goals(goals))
            search = FewestEditsPlanRepairer(get_planner(self._domain), state, goal, objects)
            at_least, edits = search.repair((), SearchEffort(self._limit))
            self._known[key] = _DistanceBounds(at_least, inf if edits is None else len(edits))
        return self._known[key]


def _tighten_distance_bounds(bounds: Sequence[_DistanceBounds]) -> list[_DistanceBounds]:
    """Return narrower bounds of the distances of successive states.

    One action lowers a distance by at most one, so bounds of one state limit the distances of its neighbours.
    """
    tightened = [*bounds]
    for i in range(1, len(tightened)):
        at_least, at_most = tightened[i]
        tightened[i] = _DistanceBounds(max(at_least, tightened[i - 1].at_least - 1), at_most)
    for i in range(len(tightened) - 2, -1, -1):
        at_least, at_most = tightened[i]
        tightened[i] = _DistanceBounds(at_least, min(at_most, tightened[i + 1].at_most + 1))
    return tightened
