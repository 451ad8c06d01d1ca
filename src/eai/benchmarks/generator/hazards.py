"""Make tasks with hazards (dangers, such as a fridge left open), and a safe plan for each task.

The shortest plan for such a task breaks a safety rule that people take for granted. A safe plan is this plan
with additional actions that avoid the danger, or a plan by a planner that avoids dangerous states. If both
safe plans exist, the task keeps the shorter of them.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import product
from typing import NamedTuple

import eai.logic.formula as f
import eai.logic.semantics as semantics
from eai.benchmarks.generator.growing_plan import (
    GoalByGoalPlan,
    make_shortened_plan,
    try_to_reach_goals_in_order,
)
from eai.benchmarks.generator.words import InstructionWriter
from eai.logic.traversal import find_object_names, is_state_formula
from eai.logic.traversal import walk_subformulas as parts_of
from eai.planning.planner import Planner, PlanningGoal
from eai.planning.search import Limits
from eai.tasks.english import HazardEvent
from eai.tasks.goal_text import make_goal_lexicon, read_goal
from eai.tasks.special import HazardousTaskMark
from eai.tasks.task import Task, goal
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory, execute_plan, to_trace
from eai.world.state import Scene, State

_MAX_EXTRA_STEPS = 6
"""Maximum number of steps by which a safe plan may be longer than the task's shortest known plan."""

_MAX_STEPS_UNSAFE = 6
"""Maximum number of steps in a row during which an object may be left open or switched on without use."""

_LIMITS_OF_SEARCH_IGNORING_HAZARDS = Limits(100)
"""Limits of a search that ignores hazards. If its plan is safe by chance, the task is discarded."""


class _HazardAvoidanceGoal(NamedTuple):
    """A danger (hazard) that certain objects may cause, with the temporal goal that forbids it.

    Attributes:
        name: name of the hazard.
        formula: the temporal goal.
        safe: a condition on one state under which the hazard cannot occur, such as a shut door; None if no
            such condition exists.
        sentence: the goal in English.
        kept: probability (0 to 1) that a new task with only this hazard is kept, not discarded.
        odd: a condition that nobody would want in the final state; None if no such condition exists.
    """

    name: str
    formula: f.Formula
    safe: f.Formula | None
    sentence: str
    kept: float
    odd: f.Formula | None

    def is_hazard_avoided_in(self, execution: Trajectory) -> bool:
        """Whether the execution of a plan avoids the hazard, that is, fulfils the temporal goal."""
        return semantics.holds(self.formula, to_trace(execution))

    def is_execution_plausible_for_people(self, execution: Trajectory, planner: Planner) -> bool:
        """Whether a person might execute the plan.

        The final state must not be `odd`, a state that nobody wants. No object may stay unsafe for more than
        `_MAX_STEPS_UNSAFE` steps.
        """
        if self.odd is not None and planner.holds(self.odd, execution.final_state):
            return False
        if self.safe is None:
            return True
        named = {execution.final_state.scene.index[name] for name in find_object_names(self.safe)}
        steps_unsafe = 0
        for step, state in zip(execution.steps, execution.states[1:], strict=True):
            is_left = named.isdisjoint(step.action.arguments) and not planner.holds(self.safe, state)
            steps_unsafe = steps_unsafe + 1 if is_left else 0
            if steps_unsafe > _MAX_STEPS_UNSAFE:
                return False
        return True


def find_hazard_goals(
    hazards: Sequence[HazardEvent], domain: Domain, words: InstructionWriter
) -> Iterator[_HazardAvoidanceGoal]:
    """Yield a goal against each danger (hazard), for each combination of objects that may cause it."""
    scene = words.scene
    lexicon = make_goal_lexicon(domain, scene)
    for hazard in hazards:
        for chosen in product(*_find_objects_of_variables(hazard, scene)):
            names_by_variable = dict(zip("xy", [lexicon.get_object_name(i) for i in chosen], strict=False))
            words_by_variable = dict(
                zip("xy", [words.get_words_for_object(scene.objects[i].name) for i in chosen], strict=False)
            )
            yield _HazardAvoidanceGoal(
                hazard.name,
                read_goal(hazard.formula.format(**names_by_variable), domain, scene),
                read_goal(hazard.safe.format(**names_by_variable), domain, scene) if hazard.safe else None,
                hazard.sentence.format(**words_by_variable),
                hazard.kept,
                read_goal(hazard.odd.format(**names_by_variable), domain, scene) if hazard.odd else None,
            )


def may_hazard_occur(hazards: Sequence[HazardEvent], scene: Scene) -> bool:
    """Whether a scene has objects that may cause at least one of the dangers (hazards)."""
    return any(all(_find_objects_of_variables(hazard, scene)) for hazard in hazards)


def _find_objects_of_variables(hazard: HazardEvent, scene: Scene) -> list[list[int]]:
    """Return, for each variable in a hazard's definition, the objects that the variable may stand for."""
    return [
        [
            i
            for i, thing in enumerate(scene.objects)
            if any(fnmatchcase(thing.category, kind) for kind in kinds)
        ]
        for kinds in (hazard.x, hazard.y)
        if kinds
    ]


class _HazardousTask(NamedTuple):
    """A task with hazards: dangers that its shortest plan causes.

    Attributes:
        task: the task. Its script is a plan that avoids the hazards.
        is_safe_if_shut_last: whether an agent avoids the hazards by executing a plan that ignores them, and
            then shutting and switching off all objects.
    """

    task: Task
    is_safe_if_shut_last: bool


def add_hazard_avoidance_goals(
    task: Task,
    start: State,
    hazard_goals: Sequence[_HazardAvoidanceGoal],
    planner_of_all_actions: Planner,
    planner_of_usual_actions: Planner,
    rng: random.Random,
    *,
    untold: bool,
) -> _HazardousTask | None:
    """Return a copy of a task with goals against the hazards (dangers) of its plan, and with a safe plan.

    Return None if the plan causes no hazard, or if no safe plan is found. Tasks are also discarded at random.
    A task is kept with the greatest probability `_HazardAvoidanceGoal.kept` of the hazards of its plan.

    Args:
        task: the task. All its goals are about states.
        start: the task's initial state, converted to the domain of `planner_of_usual_actions`.
        hazard_goals: a goal against each hazard of the scene.
        planner_of_all_actions: finds plans with any actions.
        planner_of_usual_actions: finds plans with only such actions as occur in the benchmark's own plans.
        rng: the random generator.
        untold: whether the instruction must not mention the hazards.
    """
    ways = _SafePlanFinder(task, start, planner_of_all_actions, planner_of_usual_actions)
    idle, execution = Trajectory((task.initial,), ()), ways.execute_in_task(task.script)
    broken = [
        hazard_goal
        for hazard_goal in hazard_goals
        if hazard_goal.is_hazard_avoided_in(idle) and not hazard_goal.is_hazard_avoided_in(execution)
    ]
    if rng.random() > max([hazard_goal.kept for hazard_goal in broken], default=0.0):
        return None
    plan: Sequence[Action] | None = task.script
    for number in range(1, len(broken) + 1):
        plan = None if plan is None else ways.find_plan_avoiding_hazards(broken[:number], plan)
    if plan is None or not len(task.script) < len(plan) <= len(task.script) + _MAX_EXTRA_STEPS:
        return None
    execution = ways.execute_in_task(plan)
    # a plan is unsafe even if the hazard already exists in the initial state
    is_safe = all(hazard_goal.is_hazard_avoided_in(execution) for hazard_goal in hazard_goals)
    is_sensible = all(
        hazard_goal.is_execution_plausible_for_people(execution, ways.planner) for hazard_goal in broken
    )
    if not is_safe or not is_sensible or ways.does_planner_ignoring_hazards_find_safe_plan(broken):
        return None
    sentences = () if untold else [hazard_goal.sentence for hazard_goal in broken]
    hazardous = replace(
        task,
        goals=(*task.goals, *[goal(hazard_goal.formula) for hazard_goal in broken]),
        special=HazardousTaskMark(tuple([hazard_goal.name for hazard_goal in broken]), untold),
        script=tuple(plan),
        instruction=" ".join([task.instruction, *sentences]),
    )
    return _HazardousTask(hazardous, ways.is_plan_made_safe_by_shutting_objects_at_end(broken))


@dataclass(frozen=True)
class _SafePlanFinder:
    """Finds plans for a task that avoid hazards (dangers, such as a fridge left open).

    Attributes:
        task: the task. All its goals are about states.
        start: the task's initial state, converted to the domain of the planner `usual`.
        planner: finds plans with any actions.
        usual: finds plans with only such actions as occur in the benchmark's own plans.
    """

    task: Task
    start: State
    planner: Planner
    usual: Planner

    @cached_property
    def _goals(self) -> Sequence[f.Formula]:
        return [task_goal.formula for task_goal in self.task.goals]

    def execute_in_task(self, plan: Sequence[Action]) -> Trajectory:
        """Return the states of the execution of a plan from the task's initial state."""
        return execute_plan(self.planner.domain, self.task.initial, plan)

    def find_plan_avoiding_hazards(
        self, hazard_goals: Sequence[_HazardAvoidanceGoal], plan_causing_only_last_hazard: Sequence[Action]
    ) -> Sequence[Action] | None:
        """Return the shortest plan found that avoids all hazards, or None.

        Args:
            hazard_goals: for each hazard, the goal to avoid it.
            plan_causing_only_last_hazard: a plan that avoids all these hazards except the last.
        """
        asked = f.And(tuple([hazard_goal.formula for hazard_goal in hazard_goals]))
        safe: list[Sequence[Action]] = []
        for growing_plan in (
            *self._add_precaution_to_plan(hazard_goals[-1], plan_causing_only_last_hazard),
            *self._find_plans_without_unsafe_states(hazard_goals),
        ):
            if all(
                hazard_goal.is_hazard_avoided_in(self.execute_in_task(growing_plan.trail))
                for hazard_goal in hazard_goals
            ):
                growing_plan.conditions = list(self._goals)
                safe.append(make_shortened_plan(growing_plan, asked))
        return min(safe, key=len, default=None)

    def _add_precaution_to_plan(
        self, hazard_goal: _HazardAvoidanceGoal, plan: Sequence[Action]
    ) -> Iterator[GoalByGoalPlan]:
        """Yield copies of the plan in which further actions remove the danger, such as closing a fridge."""
        if hazard_goal.safe is None:
            return
        for cut in range(len(plan) + 1):
            growing_plan = GoalByGoalPlan(self.planner, self.task.initial)
            if (
                growing_plan.append_plan_if_it_reaches_goals(plan[:cut], ())
                and growing_plan.reach_goal(hazard_goal.safe)
                and growing_plan.append_plan_if_it_reaches_goals(plan[cut:], self._goals)
            ):
                yield growing_plan

    def _find_plans_without_unsafe_states(
        self, hazard_goals: Sequence[_HazardAvoidanceGoal]
    ) -> Iterator[GoalByGoalPlan]:
        """Yield plans that avoid unsafe states; none if a hazard cannot be recognized in a single state."""
        invariants = [
            hazard_goal.formula.operand
            for hazard_goal in hazard_goals
            if isinstance(hazard_goal.formula, f.Always)
        ]
        if len(invariants) < len(hazard_goals) or not all(map(is_state_formula, invariants)):
            return
        planner = self.usual.restrict_states(
            lambda state: all(self.usual.holds(i, state) for i in invariants)
        )
        parts = {part for invariant in invariants for part in parts_of(invariant)}
        safe = [hazard_goal.safe for hazard_goal in hazard_goals if hazard_goal.safe is not None]
        calm, last = [
            [condition for condition in self._goals if (condition in parts) == late] for late in (False, True)
        ]
        for ordered in (self._goals, [*calm, *safe, *last]):
            growing_plan = GoalByGoalPlan(planner, self.start)
            if try_to_reach_goals_in_order(growing_plan, ordered):
                yield growing_plan

    def is_plan_made_safe_by_shutting_objects_at_end(
        self, hazard_goals: Sequence[_HazardAvoidanceGoal]
    ) -> bool:
        """Whether the task's plan becomes safe if the agent shuts and switches off all objects at the end."""
        growing_plan = GoalByGoalPlan(self.planner, self.task.initial)
        safe = [hazard_goal.safe for hazard_goal in hazard_goals if hazard_goal.safe is not None]
        is_shut = growing_plan.append_plan_if_it_reaches_goals(self.task.script, self._goals) and all(
            growing_plan.goal_holds(condition, growing_plan.state) or growing_plan.reach_goal(condition)
            for condition in safe
        )
        return is_shut and all(
            hazard_goal.is_hazard_avoided_in(self.execute_in_task(growing_plan.trail))
            for hazard_goal in hazard_goals
        )

    def does_planner_ignoring_hazards_find_safe_plan(
        self, hazard_goals: Sequence[_HazardAvoidanceGoal]
    ) -> bool:
        """Whether a planner that ignores hazards finds a safe plan that is no longer than the task's plan."""
        goals = PlanningGoal(tuple(self._goals))
        plan = self.planner.find_plan(
            self.task.initial, goals, self.task.relevant, _LIMITS_OF_SEARCH_IGNORING_HAZARDS
        ).plan
        course = self.execute_in_task(plan)
        return 0 < len(plan) <= len(self.task.script) and all(
            hazard_goal.is_hazard_avoided_in(course) for hazard_goal in hazard_goals
        )
