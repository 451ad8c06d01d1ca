"""Conflicts of edited plans, and the edits that may resolve them.

A plan's conflict is its first impossible step, or else a goal that the plan misses at its end. The conflict
remains until one of certain facts changes (`eai.planning.conflict_changes`). Every repair has an edit that
makes such a change.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from eai.planning.conflict_changes import (
    ChangeSet,
    NecessaryChangeFinder,
    StepUndoesWantedChange,
    simplify_check_given_other_checks,
)
from eai.planning.effect_schema import FactChange
from eai.planning.planner import PlanningGoal
from eai.planning.repair.edits import EditedPlan, PlanSteps
from eai.planning.subgoal import Subgoal, make_subgoals
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.fault import FaultKind
from eai.world.state import State

PlanMoment: TypeAlias = tuple[int, int]
"""A moment in the execution of a plan: a state, and the number of goal operators executed so far.

The state is given by its number in a `PlanStateCache`. Goal operators are those in `PlanningGoal.actions`.
"""

PlanPath: TypeAlias = tuple[PlanMoment, ...]
"""Moments of a plan, one before each entry of the plan up to the first impossible step.

If no step is impossible, one more moment is at the end.
"""

START: PlanPath = ((0, 0),)


class PlanStateCache:
    """The states to which plans for one task lead. Each state has a number and is computed once.

    Args:
        domain: the domain.
        initial: the state in which plans begin.
        goal: the goal of plans.
        change_finder: finds the changes of facts that may make a condition true or false.

    Attributes:
        by_number: the states; the index of a state is its number. The initial state has number 0.
    """

    def __init__(
        self, domain: Domain, initial: State, goal: PlanningGoal, change_finder: NecessaryChangeFinder
    ) -> None:
        self.domain = domain
        self.initial = initial
        self.goal = goal
        self.change_finder = change_finder
        self._goals = make_subgoals(goal.conditions, initial.scene)
        self.clear_cached_states()

    def clear_cached_states(self) -> None:
        """Remove all states except the initial state."""
        self.by_number = [self.initial]
        self._numbers = {self.initial: 0}
        self._after: dict[tuple[int, Action], tuple[int | None, bool]] = {}
        self._missed: dict[int, tuple[Subgoal, ...]] = {}

    def compute_moment_after_step(self, moment: PlanMoment, action: Action) -> PlanMoment | None:
        """Return the moment (`PlanMoment`) after a step, or None if the step is impossible.

        The moment's number of executed goal operators rises if the step executes the next operator that the
        goal lists.
        """
        number, taken = moment
        after, executed = self.get_next_state_number_and_is_executed(number, action)
        if after is None:
            return None
        wanted = self.goal.actions
        takes = executed and taken < len(wanted) and action.operator in wanted[taken]
        return after, taken + takes

    def get_next_state_number_and_is_executed(
        self, state_number: int, action: Action
    ) -> tuple[int | None, bool]:
        """Return the number of the state after a step, and whether the step is executed.

        The number is None if the step is impossible. A step that is skipped, because it is not needed, leads
        to the same state and is not executed.
        """
        outcome = self._after.get((state_number, action))
        if outcome is None:
            outcome = self._after[state_number, action] = self._compute_next_state_number_and_is_executed(
                state_number, action
            )
        return outcome

    def _compute_next_state_number_and_is_executed(
        self, state_number: int, action: Action
    ) -> tuple[int | None, bool]:
        state, operator = self.by_number[state_number], self.domain.compiled_operators[action.operator]
        binding = operator.bind(state, action.arguments)
        if operator.is_possible(state, binding):
            after = operator.apply(state, binding)
            after_number = self._numbers.setdefault(after, len(self.by_number))
            if after_number == len(self.by_number):
                self.by_number.append(after)
            return after_number, True
        kinds = {failure.check.check.fault for failure in operator.find_failures(state, binding)}
        kind = min(kinds, key=self.domain.precedence.index)
        return (state_number if kind is FaultKind.ADDITIONAL_STEP else None), False

    def find_unmet_goals(self, state_number: int) -> tuple[Subgoal, ...]:
        """Return the conditions of the goal that do not hold in a state."""
        missed = self._missed.get(state_number)
        if missed is None:
            state, holds = self.by_number[state_number], self.change_finder.holds
            lacking = [g for g in self._goals if holds(g.formula, g.scope, state) != g.truth]
            missed = self._missed[state_number] = tuple(lacking)
        return missed

    def compute_plan_path(
        self, plan: EditedPlan, earlier_path: PlanPath, first_entry_to_execute: int
    ) -> PlanPath:
        """Execute a plan, and return its path (`PlanPath`): the moments up to the first impossible step.

        Args:
            plan: the plan.
            earlier_path: a path that agrees with the plan's path up to the moment before
                ``first_entry_to_execute``.
            first_entry_to_execute: the index of the first step to execute.
        """
        moments = [*earlier_path[: first_entry_to_execute + 1]]
        for _, action in plan[first_entry_to_execute:]:
            after = moments[-1] if action is None else self.compute_moment_after_step(moments[-1], action)
            if after is None:
                break
            moments.append(after)
        return tuple(moments)

    def count_failed_steps_and_missed_goals(self, steps: PlanSteps, moment: PlanMoment) -> int:
        """Count the steps that fail after a moment (`PlanMoment`), plus the goals missed at the end.

        Steps that fail are skipped.
        """
        failed = 0
        for action in steps:
            if action is not None:
                after = self.compute_moment_after_step(moment, action)
                failed += after is None
                moment = after or moment
        number, taken = moment
        return failed + len(self.find_unmet_goals(number)) + len(self.goal.actions) - taken

    def plan_succeeds(self, plan: EditedPlan, path: PlanPath) -> bool:
        """Whether a plan has no impossible step and reaches the goal; ``path`` is the plan's `PlanPath`."""
        number, taken = path[-1]
        return len(path) > len(plan) and taken == len(self.goal.actions) and not self.find_unmet_goals(number)

    def reaches_goal(self, plan: EditedPlan, start: PlanMoment = START[0]) -> bool:
        """Whether a plan that begins at ``start`` (see `PlanMoment`) reaches the goal."""
        return self.plan_succeeds(plan, self.compute_plan_path(plan, (start,), 0))


EditsAtPosition: TypeAlias = tuple[int, tuple[Action | None, ...]]
"""Alternative edits at one position of a plan: the position, and actions. An edit inserts one action.

The action None stands for the deletion of the entry at the position.
"""


RepairEditsFinder: TypeAlias = "Callable[[EditedPlan, PlanPath], list[EditsAtPosition]]"
"""Function from an edited plan and its `PlanPath` to edits.

Every repair of the plan makes at least one of the edits.
"""


def make_repair_edits_finder(states: PlanStateCache) -> RepairEditsFinder:
    """Return a function that finds edits that may resolve the conflict of an edited plan.

    A plan's conflict is its first impossible step, or else a goal that the plan misses at its end.
    """
    return _ConflictResolvingEditFinder(states).find_edits_that_may_resolve_conflict


class _ConflictResolvingEditFinder:
    """Finds the conflict (the first failure) of an edited plan, and the edits that may resolve the conflict.

    Args:
        states: cache of the states to which plans for the task lead.
    """

    def __init__(self, states: PlanStateCache) -> None:
        self._states = states
        self._change_finder = states.change_finder
        self._fatal: dict[tuple[int, Action], ChangeSet] = {}
        self._improving: dict[
            tuple[int, Action], dict[FactChange, tuple[ChangeSet, StepUndoesWantedChange]]
        ] = {}
        self._lacking: dict[int, list[ChangeSet]] = {}

    def find_edits_that_may_resolve_conflict(self, plan: EditedPlan, path: PlanPath) -> list[EditsAtPosition]:
        """Return edits of a plan. Every repair of the plan contains at least one edit among them."""
        at = len(path) - 1
        number, taken = path[at]
        if at < len(plan) and (action := plan[at].action) is not None:
            deletion: list[EditsAtPosition] = [(at, (None,))] if plan[at].is_unchanged_step else []
            return deletion + self._find_edits_making_changes_or_using_operators(
                plan, path, self._get_cached_changes_to_enable_step(number, action), frozenset()
            )
        choices = [
            self._find_edits_making_changes_or_using_operators(plan, path, changes, frozenset())
            for changes in self._find_necessary_changes_for_missed_goals(number)
        ]
        if taken < len(self._states.goal.actions):
            names = [n for names in self._states.goal.actions[: taken + 1] for n in names]
            choices.append(
                self._find_edits_making_changes_or_using_operators(plan, path, frozenset(), frozenset(names))
            )
        return min(choices, key=lambda edits: sum(len(actions) for _, actions in edits))

    def _get_cached_changes_to_enable_step(self, state_number: int, action: Action) -> ChangeSet:
        """Return changes of facts after which an impossible step may be possible, or skipped as needless."""
        changes = self._fatal.get((state_number, action))
        if changes is None:
            changes = self._fatal[state_number, action] = self._find_changes_to_enable_step(
                state_number, action
            )
        return changes

    def _find_changes_to_enable_step(self, state_number: int, action: Action) -> ChangeSet:
        state = self._states.by_number[state_number]
        operator = self._states.domain.compiled_operators[action.operator].operator
        scope = operator.map_parameters(action.arguments)
        changes: set[FactChange] = set()
        for check in operator.checks:
            holds = self._change_finder.holds(check.condition, scope, state)
            if not holds:
                changes |= self._change_finder.find_necessary_changes(
                    simplify_check_given_other_checks(check, operator.checks), scope, state, truth=True
                )
                return frozenset(changes)
            if check.fault is FaultKind.ADDITIONAL_STEP:
                changes |= self._change_finder.find_necessary_changes(
                    check.condition, scope, state, truth=False
                )
        for attempt in operator.alternatives:
            for condition in (attempt.condition, *[check.condition for check in attempt.checks]):
                holds = self._change_finder.holds(condition, scope, state)
                if not holds or condition is attempt.condition:
                    changes |= self._change_finder.find_necessary_changes(
                        condition, scope, state, truth=not holds
                    )
        return frozenset(changes)

    def _find_necessary_changes_for_missed_goals(self, state_number: int) -> list[ChangeSet]:
        """Return a set of changes of facts for each missed goal. One change of each set must happen."""
        changes = self._lacking.get(state_number)
        if changes is None:
            state = self._states.by_number[state_number]
            find_changes = self._change_finder.find_necessary_changes
            changes = [
                find_changes(g.formula, g.scope, state, truth=g.truth)
                for g in self._states.find_unmet_goals(state_number)
            ]
            self._lacking[state_number] = changes
        return changes

    def _find_edits_making_changes_or_using_operators(
        self, plan: EditedPlan, path: PlanPath, fact_changes: ChangeSet, operator_names: frozenset[str]
    ) -> list[EditsAtPosition]:
        """Return edits of a plan that may make any of the changes of facts, or execute any of the operators.

        The edits are at positions up to the end of ``path``, the first failure of the plan. They include
        edits that let a step make such a change, or keep a step from undoing the change.
        """
        helping_edits: list[EditsAtPosition] = []
        actions = {
            **self._change_finder.find_actions_making_any_change(fact_changes),
            **{
                a: None
                for n in sorted(operator_names)
                for a in self._change_finder.get_actions_of_operator(n)
            },
        }
        insertions = tuple(actions)
        for position in range(len(path) - 1, -1, -1):
            helping_edits.append((position, insertions))
            if position == 0:
                break
            entry = plan[position - 1]
            if entry.action is None:
                continue
            earlier_changes, undoes = self._find_changes_before_step_for_wanted_changes(
                path[position - 1][0], entry.action, fact_changes, operator_names
            )
            if entry.is_unchanged_step and undoes:
                helping_edits.append((position - 1, (None,)))
            if not earlier_changes <= fact_changes:
                actions |= self._change_finder.find_actions_making_any_change(earlier_changes - fact_changes)
                insertions = tuple(actions)
                fact_changes |= earlier_changes
        return helping_edits

    def _find_changes_before_step_for_wanted_changes(
        self, state_number: int, step: Action, wanted_changes: ChangeSet, operator_names: frozenset[str]
    ) -> tuple[ChangeSet, StepUndoesWantedChange]:
        """Return changes of facts after which a step may make more wanted changes, or undo fewer.

        The returned changes come before the step. A step that is not needed is skipped. If the operator of a
        skipped step is in ``operator_names``, the result includes changes after which the step may be
        executed. The second returned value is whether the step undoes any wanted change.
        """
        state = self._states.by_number[state_number]
        executed = self._states.get_next_state_number_and_is_executed(state_number, step)[1]
        finder = self._change_finder
        earlier_changes = finder.get_all_changes_if_schemas_are_incomplete(step.operator)
        undoes = bool(earlier_changes) and executed
        cached = self._improving.setdefault((state_number, step), {})
        for change in (
            () if earlier_changes else finder.select_changes_step_makes_or_undoes(step, wanted_changes)
        ):
            outcome = cached.get(change)
            if outcome is None:
                outcome = cached[change] = finder.find_changes_before_step_for_wanted_change(
                    step, state, change, is_step_executed=executed
                )
            earlier_changes |= outcome[0]
            undoes = undoes or outcome[1]
        if step.operator in operator_names and not executed:
            earlier_changes |= self._change_finder.find_changes_toggling_need_for_step(
                step, state, is_step_executed=False
            )
        return earlier_changes, undoes
