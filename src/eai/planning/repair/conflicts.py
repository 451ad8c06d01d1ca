"""Conflicts of edited plans, and the edits that may help them.

A plan's conflict is its first impossible step, or a goal that it misses at its end. Every repair of the plan
has an edit by which some change happens without which the conflict stays (`eai.planning.conflict_changes`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.planning.conflict_changes import ChangeSet, ConflictChanges, remaining_condition
from eai.planning.effect_schema import FactChange
from eai.planning.planner import PlanningGoal
from eai.planning.repair.edits import EditedPlan, PlanSteps
from eai.planning.subgoal import Subgoal, subgoals_of
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.state import State

PlanMoment: TypeAlias = tuple[int, int]
"""The number of a state, and the number of action goals taken."""

PlanPath: TypeAlias = tuple[PlanMoment, ...]
"""The moment before each entry of a plan up to its conflict, and after the last entry."""

START: PlanPath = ((0, 0),)


class PlanStates:
    """The states that plans for one task lead to; each state is computed once.

    Args:
        domain: the domain.
        initial: the state in which plans begin.
        goal: the goal of plans.
        flips: the changes that conditions need.

    Attributes:
        by_number: the states; the initial one is number 0.
    """

    def __init__(
        self, domain: Domain, initial: State, goal: PlanningGoal, conflict_changes: ConflictChanges
    ) -> None:
        self.domain = domain
        self.initial = initial
        self.goal = goal
        self.conflict_changes = conflict_changes
        self._goals = subgoals_of(goal.conditions, initial.scene)
        self.forget()

    def forget(self) -> None:
        """Forget all states but the initial one."""
        self.by_number = [self.initial]
        self._numbers = {self.initial: 0}
        self._after: dict[tuple[int, Action], tuple[int | None, bool]] = {}
        self._missed: dict[int, tuple[Subgoal, ...]] = {}

    def take_step(self, moment: PlanMoment, action: Action) -> PlanMoment | None:
        """Return the moment after a step, or None if the step is impossible."""
        number, taken = moment
        after, executed = self.try_step(number, action)
        if after is None:
            return None
        wanted = self.goal.actions
        takes = executed and taken < len(wanted) and action.operator in wanted[taken]
        return after, taken + takes

    def try_step(self, number: int, action: Action) -> tuple[int | None, bool]:
        """Return the number of the state after a step, or None; and whether it is executed, not skipped."""
        found = self._after.get((number, action))
        if found is None:
            found = self._after[number, action] = self._try(number, action)
        return found

    def _try(self, number: int, action: Action) -> tuple[int | None, bool]:
        state, operator = self.by_number[number], self.domain.compiled[action.operator]
        binding = operator.bind(state, action.arguments)
        if operator.is_possible(state, binding):
            after = operator.apply(state, binding)
            found = self._numbers.setdefault(after, len(self.by_number))
            if found == len(self.by_number):
                self.by_number.append(after)
            return found, True
        kinds = {failure.check.check.fault for failure in operator.failures(state, binding)}
        kind = min(kinds, key=self.domain.precedence.index)
        return (number if kind is FaultKind.ADDITIONAL_STEP else None), False

    def missed_goals(self, number: int) -> tuple[Subgoal, ...]:
        """Return the conditions of the goal that do not hold in a state."""
        found = self._missed.get(number)
        if found is None:
            state, holds = self.by_number[number], self.conflict_changes.holds
            lacking = [g for g in self._goals if holds(g.formula, g.scope, state) != g.truth]
            found = self._missed[number] = tuple(lacking)
        return found

    def path(self, plan: EditedPlan, begin: PlanPath, at: int) -> PlanPath:
        """Return the path of a plan.

        Args:
            plan: the plan.
            begin: a path, which is also the path of the plan up to an entry.
            at: the number of the entry.
        """
        found = [*begin[: at + 1]]
        for _, action in plan[at:]:
            after = found[-1] if action is None else self.take_step(found[-1], action)
            if after is None:
                break
            found.append(after)
        return tuple(found)

    def count_failures(self, steps: PlanSteps, moment: PlanMoment) -> int:
        """Return the number of failed steps and missed goals from a moment on, without the failed steps."""
        failed = 0
        for action in steps:
            if action is not None:
                after = self.take_step(moment, action)
                failed += after is None
                moment = after or moment
        number, taken = moment
        return failed + len(self.missed_goals(number)) + len(self.goal.actions) - taken

    def succeeds(self, plan: EditedPlan, path: PlanPath) -> bool:
        """Whether a plan with this path succeeds."""
        number, taken = path[-1]
        return len(path) > len(plan) and taken == len(self.goal.actions) and not self.missed_goals(number)

    def reaches_goal(self, plan: EditedPlan, start: PlanMoment = START[0]) -> bool:
        """Whether a plan succeeds from a moment on."""
        return self.succeeds(plan, self.path(plan, (start,), 0))


HelpingEdits: TypeAlias = tuple[int, tuple[Action | None, ...]]
"""The number of an entry, and the actions to insert before it; None stands for deleting the entry."""


EditsFinder: TypeAlias = "Callable[[EditedPlan, PlanPath], list[HelpingEdits]]"
"""Returns edits of a plan, by its path, of which every repair has at least one."""


def helping_edits(states: PlanStates) -> EditsFinder:
    """Return a function that finds the edits that may help the conflicts of plans for one task."""
    return _Conflicts(states).edits


class _Conflicts:
    """Finds the conflicts of edited plans, and the edits that may help them.

    Args:
        states: the states that plans for the task lead to.
    """

    def __init__(self, states: PlanStates) -> None:
        self._states = states
        self._flips = states.conflict_changes
        self._fatal: dict[tuple[int, Action], ChangeSet] = {}
        self._lacking: dict[int, list[ChangeSet]] = {}

    def edits(self, plan: EditedPlan, path: PlanPath) -> list[HelpingEdits]:
        """Return edits of which every repair of a plan has at least one."""
        at = len(path) - 1
        number, taken = path[at]
        if at < len(plan) and (action := plan[at].action) is not None:
            own: list[HelpingEdits] = [(at, (None,))] if plan[at].is_kept else []
            return own + self._helping(plan, path, self._unblocking(number, action), frozenset())
        choices = [self._helping(plan, path, changes, frozenset()) for changes in self._reaching(number)]
        if taken < len(self._states.goal.actions):
            names = [n for names in self._states.goal.actions[: taken + 1] for n in names]
            choices.append(self._helping(plan, path, frozenset(), frozenset(names)))
        return min(choices, key=lambda edits: sum(len(actions) for _, actions in edits))

    def _unblocking(self, number: int, action: Action) -> ChangeSet:
        """Return the changes of which one is needed before an impossible step is possible, or is skipped."""
        found = self._fatal.get((number, action))
        if found is None:
            found = self._fatal[number, action] = self._find_unblocking(number, action)
        return found

    def _find_unblocking(self, number: int, action: Action) -> ChangeSet:
        state, operator = (
            self._states.by_number[number],
            self._states.domain.compiled[action.operator].operator,
        )
        scope = operator.scope(action.arguments)
        found: set[FactChange] = set()
        for check in operator.checks:
            holds = self._flips.holds(check.condition, scope, state)
            if not holds:
                found |= self._flips.find_changes(
                    remaining_condition(check, operator.checks), scope, state, truth=True
                )
                return frozenset(found)
            if check.fault is FaultKind.ADDITIONAL_STEP:
                found |= self._flips.find_changes(check.condition, scope, state, truth=False)
        for each in operator.tries:
            for condition in (each.condition, *[check.condition for check in each.checks]):
                holds = self._flips.holds(condition, scope, state)
                if not holds or condition is each.condition:
                    found |= self._flips.find_changes(condition, scope, state, truth=not holds)
        return frozenset(found)

    def _reaching(self, number: int) -> list[ChangeSet]:
        """Return, for each missed goal in a state, the changes of which one is needed to reach it."""
        found = self._lacking.get(number)
        if found is None:
            state, of = self._states.by_number[number], self._flips.find_changes
            found = [of(g.formula, g.scope, state, truth=g.truth) for g in self._states.missed_goals(number)]
            self._lacking[number] = found
        return found

    def _helping(
        self, plan: EditedPlan, path: PlanPath, changes: ChangeSet, names: frozenset[str]
    ) -> list[HelpingEdits]:
        """Return the edits that may make one of some changes, or use one of some operators."""
        found: list[HelpingEdits] = []
        actions = {
            **self._flips.actions(changes),
            **{a: None for n in sorted(names) for a in self._flips.actions_of(n)},
        }
        listed = tuple(actions)
        for place in range(len(path) - 1, -1, -1):
            found.append((place, listed))
            if place == 0:
                break
            entry = plan[place - 1]
            if entry.action is None:
                continue
            behind, undoes = self._behind(path[place - 1][0], entry.action, changes, names)
            if entry.is_kept and undoes:
                found.append((place - 1, (None,)))
            if not behind <= changes:
                actions |= self._flips.actions(behind - changes)
                listed = tuple(actions)
                changes |= behind
        return found

    def _behind(
        self, number: int, action: Action, changes: ChangeSet, names: frozenset[str]
    ) -> tuple[ChangeSet, bool]:
        """Return the changes by which a step may help, or undo nothing; and whether it undoes a change."""
        state, executed = self._states.by_number[number], self._states.try_step(number, action)[1]
        behind, undoes = self._flips.changes_before_step(action, state, changes, executed=executed)
        if action.operator in names and not executed:
            behind |= self._flips.changes_for_skipping(action, state, executed=False)
        return behind, undoes
