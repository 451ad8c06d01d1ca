"""The smallest repair of a plan: its edits as they are told, of equally small ones the most natural."""

from __future__ import annotations

from functools import cached_property, lru_cache

from eai.abilities.notation.plan_form import WrittenPlan, WrittenStep
from eai.abilities.notation.plans import PlanNotation
from eai.abilities.repair import EFFORT, KINDS, Edit, EditKind, Repair, blame_of
from eai.abilities.reports import action_text
from eai.abilities.verdict import PlanVerdict
from eai.logic.traversal import object_names
from eai.planning.planner import get_planner
from eai.planning.repair.edits import PlanEdit, PlanSteps
from eai.planning.repair.search import Repairer
from eai.planning.search import Effort
from eai.tasks.planning import planning_goal
from eai.tasks.task import Task
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind

_COSTS: dict[EditKind, int] = {"insert": 0, "object": 1, "hand": 1, "action": 2, "delete": 3, "step": 4}
"""Which kind of edit is told first."""

_PER_STEP, _MOST = 200, 5_000
"""How many steps may be tried for the nearness of a plan: for each step that it has or lacks, and in all."""

_REMEMBERED = 10_000
"""Of so many plans for a task it is remembered how near they are."""

_HANDS = {("LEFT", "RIGHT"), ("RIGHT", "LEFT")}


class PlanMender:
    """Tells the smallest repairs of the answers to one task.

    Args:
        task: the task.
        domain: the world.
        notation: how plans are written.
    """

    def __init__(self, task: Task, domain: Domain, notation: PlanNotation) -> None:
        self.task = task
        self.domain = domain
        self._notation = notation
        self._object = notation.objects(task)
        self._remembered = lru_cache(_REMEMBERED)(self._near)

    def steps(self, plan: WrittenPlan) -> tuple[Action | None, ...]:
        """The steps of a plan; None for each that means nothing."""
        return tuple(map(self._step, plan.steps))

    def _step(self, step: WrittenStep) -> Action | None:
        operator = self._notation.operator(step.action)
        objects = [self._object(name) for name in step.objects]
        known = [index for index in objects if index is not None]
        fits = len(known) == len(objects) == self.domain.arities.get(operator)
        return Action(operator, tuple(known)) if fits else None

    def mend(self, plan: WrittenPlan, verdict: PlanVerdict, limit: int) -> Repair:
        """The smallest repair of a plan, with bounded effort.

        Args:
            plan: the plan.
            verdict: the verdict on it.
            limit: how many steps may be tried, about.
        """
        if verdict.success:
            return Repair(at_most=0)
        if (why := self._why_unknown) is not None:
            return Repair(why_null=why)
        steps, effort = self.steps(plan), Effort(limit)
        mender = self._mender(steps)
        at_least, edits = mender.repair(steps, effort)
        if edits is None:
            return Repair(at_least, effort=effort.used)
        shown = len(steps) if verdict.error is None else verdict.error.step
        if at_least == len(edits) == 1 and not mender.conflict_changes.is_partial:
            return self._single(plan, steps, mender, shown, effort.used)
        told = tuple([self._told(edit, plan, steps) for edit in edits])
        return Repair(at_least, len(told), edits=told, effort=effort.used)

    @property
    def _why_unknown(self) -> str | None:
        """Why nothing is known of how far plans of the task are from success; None if something is."""
        if self.task.missing:
            return "unsolvable"
        if any(goal.is_over_time for goal in self.task.goals):
            return "over_time"
        order = self.domain.precedence
        if order.index(FaultKind.ADDITIONAL_STEP) > order.index(FaultKind.WRONG_ORDER):
            return "order"
        return None

    def nearness(self, steps: PlanSteps) -> float | None:
        """How near steps are to success: 1 - d / n for d edits, 0 if there are more than n.

        Every plan of the task has n steps at least, so that no steps at all are as near as 0. The upper bound
        of d counts, so that effort that runs out never pays: so many steps are tried for each of the steps
        and of n. Inserted steps are about the task's objects.

        Args:
            steps: the steps; None for each that means nothing.

        Returns:
            The nearness, from 0 to 1; None where nothing is known of it.
        """
        if self._why_unknown is not None:
            return None
        number = len(steps) + self._least
        effort = min(_MOST, _PER_STEP << number.bit_length())  # one of a few, as each starts a search
        return self._remembered(tuple(steps), effort)

    def _near(self, steps: PlanSteps, limit: int) -> float:
        """The nearness of steps, by so much effort."""
        if steps.count(None) >= self._least:
            return 0.0
        _, edits = self._mender(()).repair(steps, Effort(limit))
        if not edits:
            return float(edits is not None)
        return max(0.0, 1 - len(edits) / self._least)

    @cached_property
    def _least(self) -> int:
        """So many steps every plan of the task has, as far as it is proved."""
        return self._mender(()).least(Effort(EFFORT))

    def _mender(self, steps: PlanSteps) -> Repairer:
        """Mends plans with the objects of some steps besides those of the task."""
        named = [index for step in steps if step is not None for index in step.arguments]
        return _mender_of(self, tuple(dict.fromkeys([*self.task.relevant, *sorted(named)])))

    def _single(
        self, plan: WrittenPlan, steps: PlanSteps, mender: Repairer, shown: int | None, effort: int
    ) -> Repair:
        """The repair of a plan that one edit mends."""
        names = [o.name for o in self.domain.operators]
        known = self._known(steps)
        found = [*mender.single_edits(steps)]
        needless = {edit.removed for edit in found if edit.action is None}
        failed = steps[shown] if shown is not None and shown < len(steps) else None
        failing = set() if failed is None else {*failed.arguments}

        def key(edit: PlanEdit) -> tuple[object, ...]:
            action = edit.action
            new = () if action is None else tuple(set(action.arguments) - known)
            kind = self._kind(edit, plan, steps)
            place = names.index(action.operator) if action is not None else -1
            arguments = () if action is None else action.arguments
            cost = 0 if edit.removed is not None and steps[edit.removed] is None and action else _COSTS[kind]
            if edit.removed in needless and edit.action is not None:  # to delete it is enough
                cost = len(KINDS)
            elsewhere = failing.isdisjoint(arguments)
            return (
                len(new),
                _away(edit.step, shown, len(steps)),
                cost,
                -edit.step,
                elsewhere,
                place,
                arguments,
            )

        singles = sorted(found, key=key)
        told = [self._told(edit, plan, steps) for edit in singles]
        kinds = {edit.kind for edit in told}
        blame, blamed = blame_of(told)
        return Repair(
            1,
            1,
            edits=(told[0],),
            ties=len(told),
            kinds=tuple([kind for kind in KINDS if kind in kinds]),
            blame=blame,
            blamed=blamed,
            effort=effort,
        )

    def _known(self, steps: PlanSteps) -> set[int]:
        """The objects of an answer and of the goals."""
        index = self.task.scene.index
        named = [name for goal in self.task.goals for name in object_names(goal.formula)]
        found = {index[name] for name in named if name in index}
        return found | {i for step in steps if step is not None for i in step.arguments}

    def _kind(self, edit: PlanEdit, plan: WrittenPlan, steps: PlanSteps) -> EditKind:
        if edit.action is None:
            return "delete"
        if edit.removed is None:
            return "insert"
        was = steps[edit.removed]
        operator = self._notation.operator(plan.steps[edit.removed].action) if was is None else was.operator
        if operator == edit.action.operator:
            return "object"
        if was is None or was.arguments[-1:] != edit.action.arguments[-1:]:
            return "step"
        words = zip(operator.split("_"), edit.action.operator.split("_"), strict=False)
        changed = {pair for pair in words if pair[0] != pair[1]}
        return "hand" if len(changed) == 1 and changed <= _HANDS else "action"

    def _told(self, edit: PlanEdit, plan: WrittenPlan, steps: PlanSteps) -> Edit:
        """An edit with what it is about as text."""
        kind = self._kind(edit, plan, steps)
        action = "" if edit.action is None else action_text(edit.action, self.task.scene)
        return Edit(
            kind, edit.step, action, "" if edit.removed is None else self._was(edit.removed, plan, steps)
        )

    def _was(self, number: int, plan: WrittenPlan, steps: PlanSteps) -> str:
        step = steps[number]
        if step is not None:
            return action_text(step, self.task.scene)
        written = plan.steps[number]
        return f"{written.action}({', '.join(map(str, written.objects))})"


@lru_cache(maxsize=16)
def _mender_of(plans: PlanMender, usable: tuple[int, ...]) -> Repairer:
    return Repairer(get_planner(plans.domain), plans.task.initial, planning_goal(plans.task), usable)


def _away(step: int, shown: int | None, end: int) -> int:
    """How far an edit is from where the failure showed: there or just before, earlier, or later."""
    if shown is None or step == shown:
        return 0
    return 1 if step < shown or shown == end else 2
