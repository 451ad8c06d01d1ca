"""Find the smallest repair of a plan: the fewest edits after which the plan succeeds.

If several single edits repair the plan, the most natural edit is reported. It adds few objects that neither
the goals nor the plan name, and is at the failed step if possible.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

from eai.abilities.notation.plan_form import WrittenPlan, WrittenStep
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.repair import (
    DEFAULT_EFFORT,
    EDIT_KINDS,
    Edit,
    EditKind,
    SmallestPlanRepair,
    classify_and_locate_fault,
)
from eai.abilities.reports import action_text
from eai.abilities.verdict import PlanVerdict
from eai.logic.traversal import find_object_names
from eai.planning.planner import get_planner
from eai.planning.repair.edits import PlanEdit, PlanSteps
from eai.planning.repair.search import FewestEditsPlanRepairer
from eai.planning.search import SearchEffort
from eai.tasks.planning import to_planning_goal
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind

_KIND_RANKS: dict[EditKind, int] = {"insert": 0, "object": 1, "hand": 1, "action": 2, "delete": 3, "step": 4}
"""Rank of each kind of edit; the edit with the lowest rank is preferred.

If several edits could each repair a plan, the best edit is reported. The rank decides between edits that add
equally many new objects at equally good positions.
"""

_STEPS_TRIED_PER_STEP, _MAX_CLOSENESS_STEPS = 200, 5_000
"""Limits of the search that computes a plan's closeness to success: tried steps per plan step, and in all.

The first limit is multiplied by a number of plan steps: the steps of the plan plus a lower bound of the steps
of a shortest plan. This number is first rounded up to a larger power of 2.
"""

_MAX_CACHED_PLANS = 10_000
"""Maximum number of plans for a task whose closeness to success (few needed edits) is cached."""

_HAND_CHANGES = {("LEFT", "RIGHT"), ("RIGHT", "LEFT")}


class PlanRepairer:
    """Finds the smallest repairs of the plans in answers to one task.

    Args:
        task: the task.
        domain: the domain in which plans are executed.
        notation: the notation of plans.
    """

    def __init__(self, task: Task, domain: Domain, notation: PlanNotation) -> None:
        self.task = task
        self.domain = domain
        self._notation = notation
        self._object = notation.make_object_lookup(task)
        self._cached_closeness = lru_cache(_MAX_CACHED_PLANS)(self._compute_uncached_closeness_to_success)

    def read_steps(self, plan: WrittenPlan) -> tuple[Action | None, ...]:
        """Return the action of each step of a plan.

        It is None for a step that names something unknown or has a wrong number of objects.
        """
        return tuple(map(self._to_action, plan.steps))

    def _to_action(self, step: WrittenStep) -> Action | None:
        operator = self._notation.to_operator_name(step.action)
        objects = [self._object(name) for name in step.objects]
        indices = [index for index in objects if index is not None]
        fits = len(indices) == len(objects) == self.domain.operator_arities.get(operator)
        return Action(operator, tuple(indices)) if fits else None

    def find_smallest_repair(
        self, plan: WrittenPlan, verdict: PlanVerdict, max_tried_steps: int
    ) -> SmallestPlanRepair:
        """Return the smallest repair of a plan that a search with limited effort finds.

        Args:
            plan: the plan.
            verdict: the verdict on the plan.
            max_tried_steps: approximate number of steps that may be tried.
        """
        if verdict.success:
            return SmallestPlanRepair(at_most=0)
        if (why := self.why_distance_unknown) is not None:
            return SmallestPlanRepair(why_null=why)
        steps, effort = self.read_steps(plan), SearchEffort(max_tried_steps)
        repairer = self._make_repairer(steps)
        at_least, edits = repairer.repair(steps, effort)
        if edits is None:
            return SmallestPlanRepair(at_least, effort=effort.used)
        shown = len(steps) if verdict.error is None else verdict.error.step
        if (
            at_least == len(edits) == 1
            and not repairer.change_finder.has_operator_with_too_many_actions_to_list
        ):
            return self._make_single_edit_repair(plan, steps, repairer, shown, effort.used)
        told = tuple([self._convert_plan_edit_to_readable_edit(edit, plan, steps) for edit in edits])
        return SmallestPlanRepair(at_least, len(told), edits=told, effort=effort.used)

    @property
    def why_distance_unknown(self) -> str | None:
        """Reason why no plan's distance from success (number of needed edits) can be computed, or None."""
        if self.task.has_no_plan:
            return "unsolvable"
        if any(goal.is_temporal for goal in self.task.goals):
            return "over_time"
        order = self.domain.precedence
        if order.index(FaultKind.ADDITIONAL_STEP) > order.index(FaultKind.WRONG_ORDER):
            return "order"
        return None

    def compute_closeness_to_success(self, steps: PlanSteps) -> float | None:
        """Return the closeness of a plan to success: ``1 - d / n``, or 0 if this is negative.

        Here d is the number of edits after which the plan succeeds, and n is a lower bound of the length of
        plans for the task. So an empty plan has closeness 0. If the search finds only bounds of d, the upper
        bound is used, so that a search that stops early never raises closeness. The effort grows with the
        number of steps plus n. Inserted steps use only objects of the task.

        Args:
            steps: the actions of the plan's steps, as `read_steps` returns them.

        Returns:
            The closeness, from 0 to 1, or None if it is unknown.
        """
        if self.why_distance_unknown is not None:
            return None
        return self._cached_closeness(tuple(steps))

    def _compute_uncached_closeness_to_success(self, steps: PlanSteps) -> float:
        repairer = self._make_repairer(())
        if repairer.reaches_goal(steps) and not repairer.reaches_goal(()):
            return 1.0
        number = len(steps) + self._min_plan_steps
        effort_limit = min(_MAX_CLOSENESS_STEPS, _STEPS_TRIED_PER_STEP << number.bit_length())
        return self._compute_closeness_to_success_by_repair(steps, effort_limit)

    def _compute_closeness_to_success_by_repair(self, steps: PlanSteps, effort_limit: int) -> float:
        if steps.count(None) >= self._min_plan_steps:
            return 0.0
        _, edits = self._make_repairer(()).repair(steps, SearchEffort(effort_limit), self._min_plan_steps)
        if not edits:
            return float(edits is not None)
        return max(0.0, 1 - len(edits) / self._min_plan_steps)

    @cached_property
    def _min_plan_steps(self) -> int:
        """A proved lower bound of the number of steps in every plan for the task."""
        return self._make_repairer(()).compute_proved_min_plan_length(SearchEffort(DEFAULT_EFFORT))

    def _make_repairer(self, steps: PlanSteps) -> FewestEditsPlanRepairer:
        """Return a repairer whose edits may use the objects of the task and the objects in ``steps``."""
        named = [index for step in steps if step is not None for index in step.arguments]
        return _get_cached_repairer(self, tuple(dict.fromkeys([*self.task.relevant, *sorted(named)])))

    def _make_single_edit_repair(
        self,
        plan: WrittenPlan,
        steps: PlanSteps,
        repairer: FewestEditsPlanRepairer,
        failed_step: int | None,
        search_effort: int,
    ) -> SmallestPlanRepair:
        names = [o.name for o in self.domain.operators]
        mentioned = self._find_mentioned_objects(steps)
        single_edits = [*repairer.find_single_edit_repairs(steps)]
        needless = {edit.removed for edit in single_edits if edit.action is None}
        failed = steps[failed_step] if failed_step is not None and failed_step < len(steps) else None
        failing = set() if failed is None else {*failed.arguments}

        def make_edit_sort_key(edit: PlanEdit) -> tuple[object, ...]:
            action = edit.action
            new = () if action is None else tuple(set(action.arguments) - mentioned)
            kind = self._classify_edit(edit, plan, steps)
            rank = names.index(action.operator) if action is not None else -1
            arguments = () if action is None else action.arguments
            cost = (
                0
                if edit.removed is not None and steps[edit.removed] is None and action
                else _KIND_RANKS[kind]
            )
            if edit.removed in needless and edit.action is not None:  # deleting the step is enough
                cost = len(EDIT_KINDS)
            elsewhere = failing.isdisjoint(arguments)
            return (
                len(new),
                _rank_edit_position(edit.step, failed_step, len(steps)),
                cost,
                -edit.step,
                elsewhere,
                rank,
                arguments,
            )

        singles = sorted(single_edits, key=make_edit_sort_key)
        told = [self._convert_plan_edit_to_readable_edit(edit, plan, steps) for edit in singles]
        kinds = {edit.kind for edit in told}
        blame, blamed = classify_and_locate_fault(told)
        return SmallestPlanRepair(
            1,
            1,
            edits=(told[0],),
            ties=len(told),
            kinds=tuple([kind for kind in EDIT_KINDS if kind in kinds]),
            blame=blame,
            blamed=blamed,
            effort=search_effort,
        )

    def _find_mentioned_objects(self, steps: PlanSteps) -> set[int]:
        index = self.task.scene.index
        named = [name for goal in self.task.goals for name in find_object_names(goal.formula)]
        in_goals = {index[name] for name in named if name in index}
        return in_goals | {i for step in steps if step is not None for i in step.arguments}

    def _classify_edit(self, edit: PlanEdit, plan: WrittenPlan, steps: PlanSteps) -> EditKind:
        if edit.action is None:
            return "delete"
        if edit.removed is None:
            return "insert"
        was = steps[edit.removed]
        operator = (
            self._notation.to_operator_name(plan.steps[edit.removed].action) if was is None else was.operator
        )
        if operator == edit.action.operator:
            return "object"
        if was is None or was.arguments[-1:] != edit.action.arguments[-1:]:
            return "step"
        words = zip(operator.split("_"), edit.action.operator.split("_"), strict=False)
        changed = {pair for pair in words if pair[0] != pair[1]}
        return "hand" if len(changed) == 1 and changed <= _HAND_CHANGES else "action"

    def _convert_plan_edit_to_readable_edit(
        self, edit: PlanEdit, plan: WrittenPlan, steps: PlanSteps
    ) -> Edit:
        kind = self._classify_edit(edit, plan, steps)
        action = "" if edit.action is None else action_text(edit.action, self.task.scene)
        return Edit(
            kind,
            edit.step,
            action,
            "" if edit.removed is None else self._write_step_text(edit.removed, plan, steps),
        )

    def _write_step_text(self, step_number: int, plan: WrittenPlan, steps: PlanSteps) -> str:
        step = steps[step_number]
        if step is not None:
            return action_text(step, self.task.scene)
        written = plan.steps[step_number]
        return f"{written.action}({', '.join(map(str, written.objects))})"


@lru_cache(maxsize=16)
def _get_cached_repairer(
    plan_repairer: PlanRepairer, usable_objects: tuple[int, ...]
) -> FewestEditsPlanRepairer:
    return FewestEditsPlanRepairer(
        get_planner(plan_repairer.domain),
        plan_repairer.task.initial,
        to_planning_goal(plan_repairer.task),
        usable_objects,
    )


def _rank_edit_position(step: int, failed_step: int | None, plan_length: int) -> int:
    """Return the rank of an edit by its position: 0 at the failed step, 1 before this step, 2 after it."""
    if failed_step is None or step == failed_step:
        return 0
    return 1 if step < failed_step or failed_step == plan_length else 2
