"""Search all ways to execute a sequence of subgoals, and compute how far each way gets towards the goal.

A subgoal can have several plans, and an ``or`` offers a choice of subgoals. Each choice makes a branch, and
all branches are explored. Branches with the same state, the same remaining subgoals and the same progress
have the same future. Only the best branches among these are continued, so the cost does not double with every
choice. A search without such merging would report the same branch, except for one detail. Earlier states of a
branch can turn its last error from a missing step into a wrong order; merging ignores this.

The goal is a sequence of state formulas, ``f1 then f2 then ...``, as are all goals of the data set. The first
part is met at the earliest position at which it holds. Every other part is met at the earliest position at
which it holds after the previous part was met. An action belongs to the position of the state in which it is
taken; the last position has no action. So the search must remember only the number of parts met so far. The
result equals that of `eai.logic.semantics` for such sequences (a test compares the two).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Literal, NamedTuple, TypeAlias

from typing_extensions import assert_never

import eai.logic.formula as f
from eai.abilities.subgoal_decomposition.program import (
    TOO_FAR,
    ActionSequence,
    CheckSubgoalHoldsInstruction,
    ExecuteSubgoalPlansInstruction,
    Instruction,
    SubgoalForkInstruction,
    SubgoalProgram,
)
from eai.base.errors import InputError
from eai.logic.ltl_printer import format_ltl
from eai.logic.rewriting import rewrite_leaves
from eai.logic.traversal import is_state_formula, walk_subformulas
from eai.planning.search import SearchEffort
from eai.tasks.goal_test import StateTest, make_variables_of_action_arguments
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, attempt_action
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.operator import Check
from eai.world.state import Scene, State


class _GoalPart:
    """One part of a goal: a formula about a state and the action after it. The parts are met in order."""

    __slots__ = ("_actions", "_formula", "_scene", "_test")

    def __init__(self, formula: f.Formula, scene: Scene) -> None:
        self._formula = formula
        self._scene = scene
        self._actions = frozenset(
            [part.action for part in walk_subformulas(formula) if isinstance(part, f.Occurs)]
        )
        self._test = cache(self._compile_test_for_taken_action)

    def holds(self, state: State, action: Action | None) -> bool:
        """Whether the formula holds at a position: in a state, and for the action taken in the state."""
        if action is None or action.operator not in self._actions:
            return self._test(None, 0)(state)
        return self._test(action.operator, len(action.arguments))(state, action.arguments)

    def _compile_test_for_taken_action(self, action_name: str | None, argument_count: int) -> StateTest:
        """Return a test of this part of the goal for states in which the agent takes the named action.

        The name is None if the agent takes no action, or an action that does not occur in the formula.
        """
        arguments = make_variables_of_action_arguments(argument_count)
        formula = self._formula
        at_action = (
            rewrite_leaves(formula, lambda leaf, _: _evaluate_action_leaf(leaf, action_name, arguments))
            if self._actions
            else formula
        )
        return StateTest(at_action, self._scene, argument_count)


def _evaluate_action_leaf(
    leaf: f.Leaf, taken_action: str | None, taken_arguments: tuple[f.Variable, ...]
) -> f.Formula:
    """Return an atomic formula, simplified for states in which the agent takes a given action.

    A formula that demands this action becomes a test of the action's objects, or true if it names no objects.
    A formula that demands another action, or another number of objects, becomes false.
    All other formulas stay.
    """
    if not isinstance(leaf, f.Occurs):
        return leaf
    if leaf.action != taken_action or len(leaf.arguments) not in (0, len(taken_arguments)):
        return f.FALSE
    pairs = zip(leaf.arguments, taken_arguments, strict=False)
    return f.And(tuple(f.Equals(term, argument) for term, argument in pairs))


class GoalProgress:
    """The parts of a goal that must be met in order, compiled for one scene.

    Args:
        goal: the goal, a sequence of formulas about states.
        scene: the scene.
        final_test: a further test of the last state; None for no test.
        trajectory_test: a further test of the trajectory from start to end; None for no test.

    Attributes:
        actions: names of the operators that the goal mentions.
        trajectory_test: a further test of the trajectory from start to end; None for no test.

    Raises:
        InputError: the goal is not a sequence of state formulas.
        DomainError: the goal uses an unknown predicate or object.
    """

    def __init__(
        self,
        goal: f.Formula,
        scene: Scene,
        final_test: Callable[[State], bool] | None = None,
        trajectory_test: Callable[[Trajectory], bool] | None = None,
    ) -> None:
        parts = goal.parts if isinstance(goal, f.Then) else (goal,)
        for part in parts:
            if not is_state_formula(part):
                raise InputError(
                    "a goal must be a sequence of state formulas, 'f then g then ...', "
                    f"not {format_ltl(part)}"
                )
        self._parts = tuple(_GoalPart(part, scene) for part in parts)
        self._at_end = final_test
        self.trajectory_test = trajectory_test
        self.actions = frozenset(
            [e.action for part in parts for e in walk_subformulas(part) if isinstance(e, f.Occurs)]
        )

    def count_goal_parts_met_after_action(self, parts_met_before: int, state: State, action: Action) -> int:
        """Return the number of goal parts that are met after the agent takes an action in a state.

        Before the action, ``parts_met_before`` parts were met.
        """
        if parts_met_before < len(self._parts) and self._parts[parts_met_before].holds(state, action):
            return parts_met_before + 1
        return parts_met_before

    def is_goal_reached_at_end(self, parts_met: int, final_state: State) -> bool:
        """Whether the goal is reached at the end of a trajectory.

        Before the final state, ``parts_met`` parts of the goal were met. The final state can meet only one
        more part: the last.
        """
        missing = len(self._parts) - parts_met
        met_by_now = missing == 0 or (missing == 1 and self._parts[-1].holds(final_state, None))
        return met_by_now and (self._at_end is None or self._at_end(final_state))


_MIN_BRANCHES_TO_MERGE = 5
"""Minimum number of branches (ways to execute the subgoals) among which equal branches are merged.

A search with fewer branches is faster without merging.
"""


class _StepWithPredecessor(NamedTuple):
    """A tried step, linked to the step before.

    Branches with the same first steps share these linked steps.
    """

    step: Step
    before: _StepWithPredecessor | None


class SubgoalExecutionBranch(NamedTuple):
    """One way to execute the subgoals, up to the present point of the search.

    Attributes:
        past: the initial state and the state after each executed action.
        tried: all tried actions, with the fault of each action that was not executed.
        errors: number of faults.
        met: number of met parts of the goal.
        subgoal: number of the subgoal that was executed last.
        failure: the fault that ended the branch; None if no fault ended it.
        executed: number of actions that were executed for the last subgoal.
        refined: number of subgoals for which actions were executed.
    """

    past: History
    tried: _StepWithPredecessor | None = None
    errors: int = 0
    met: int = 0
    subgoal: int = 0
    failure: Fault | None = None
    executed: int = 0
    refined: int = 0

    def count_actions_executed_for_subgoal(self, subgoal: int) -> int:
        """Return the number of actions that this branch has executed for its present or next subgoal.

        The branch stores this number only for the subgoal that it executed last. For the next subgoal, it has
        executed no action yet.
        """
        return self.executed if self.subgoal == subgoal else 0

    @property
    def state(self) -> State:
        """The state after the last executed action."""
        return self.past.state

    @property
    def steps(self) -> tuple[Step, ...]:
        """All tried actions, in order."""
        steps, tried = [], self.tried
        while tried is not None:
            steps.append(tried.step)
            tried = tried.before
        return tuple(reversed(steps))

    @property
    def trajectory(self) -> Trajectory:
        """The trajectory: the tried actions and the states after them."""
        return Trajectory(self.past.states, self.steps)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All faults in order: the faults of steps, then that of a required subgoal that does not hold."""
        faults = tuple([step.fault for step in self.steps if step.fault is not None])
        if self.failure is None or len(faults) == self.errors:
            return faults
        return (*faults, self.failure)


def _get_success_sort_key(branch: SubgoalExecutionBranch) -> int:
    """Return the sort key of a branch that reaches the goal: fewer errors (needless steps) come first."""
    return branch.errors


def _get_failure_sort_key(branch: SubgoalExecutionBranch) -> tuple[int, int]:
    """Return the sort key of a failed branch: fewer errors come first, then more executed actions."""
    return branch.errors, -branch.past.number


def _drop_branches_with_same_future(
    branches: list[SubgoalExecutionBranch], subgoal_number: int, *, compare_executed_actions: bool
) -> list[SubgoalExecutionBranch]:
    """Return at most two branches of each group that the rest of the search would continue in the same way.

    Two branches of a group can be the best in the end. If the goal is reached, a branch with fewer errors is
    better (`_get_success_sort_key`). Otherwise `_get_failure_sort_key` decides. Fewer branches than
    `_MIN_BRANCHES_TO_MERGE` are returned unchanged.

    Args:
        branches: the branches, in order.
        subgoal_number: number of the subgoal with which the branches continue.
        compare_executed_actions: whether branches with different executed actions are in different groups.
            This is so if the goal depends on these actions.
    """
    if len(branches) < _MIN_BRANCHES_TO_MERGE:
        return branches
    groups: dict[object, list[SubgoalExecutionBranch]] = {}
    for branch in branches:
        executed_actions = branch.trajectory.executed_actions if compare_executed_actions else ()
        key = (
            branch.state,
            branch.met,
            branch.count_actions_executed_for_subgoal(subgoal_number),
            executed_actions,
        )
        groups.setdefault(key, []).append(branch)
    best = [
        (min(branches_to_merge, key=_get_success_sort_key), min(branches_to_merge, key=_get_failure_sort_key))
        for branches_to_merge in groups.values()
    ]
    best_ids = {id(branch) for pair in best for branch in pair}
    return [branch for branch in branches if id(branch) in best_ids]


_PAST_STATES_PER_ACTION = 16
"""Number of past states for which testing a failed check counts as much effort as applying one action."""


_NO_SUBGOAL = -1
"""Number that stands for no subgoal: the subgoal of the instruction that ends a `SubgoalProgram`."""


def _mark_branch_as_failed(
    branch: SubgoalExecutionBranch,
    subgoal_number: int,
    failed_check: Check,
    state_where_subgoal_held: int | None = None,
) -> SubgoalExecutionBranch:
    """Return a branch that fails at a subgoal, although no action of the branch fails.

    ``state_where_subgoal_held`` is the number of the last state in which the subgoal held, or None.
    """
    kind = failed_check.fault if state_where_subgoal_held is None else FaultKind.WRONG_ORDER
    fault = Fault(kind, failed_check, state_where_subgoal_held)
    return branch._replace(errors=branch.errors + 1, subgoal=subgoal_number, failure=fault)


@dataclass(frozen=True, slots=True)
class ExplorationLimits:
    """Limits of a search.

    Attributes:
        attempts: maximum number of tried actions, over all branches.
        branches: maximum number of branches that continue at an instruction that can make new branches. All
            further branches are dropped there. After the last subgoal no branch is dropped.
        effort: maximum number of actions applied to states to find plans, over all branches.
    """

    attempts: int = 20_000
    branches: int = 16
    effort: int = 100_000


ExplorationEnd: TypeAlias = Literal["complete", "attempts", "branches", "effort"]
"""Reason for the end of a search: it is complete, or reached one of its limits."""


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """The result of a search.

    Attributes:
        reported: the best branch. A branch that reaches the goal is preferred, then a branch that executes
            all subgoals, then a branch with fewer errors. Among equal branches that do not reach the goal, a
            branch with more executed actions is preferred. The first branch wins all other ties.
        success: whether a branch reaches the goal.
        executable: whether a branch executes all subgoals.
        end: why the search ended. If the search is not complete, ``reported`` is the best branch so far.
        attempts: number of tried actions.
        ended: all branches that ended, in the order of the search.
    """

    reported: SubgoalExecutionBranch
    success: bool
    executable: bool
    end: ExplorationEnd
    attempts: int
    ended: tuple[SubgoalExecutionBranch, ...] = ()


def explore_subgoal_program(
    domain: Domain, initial: State, program: SubgoalProgram, goal: GoalProgress, limits: ExplorationLimits
) -> ExplorationResult:
    """Execute a program of subgoals in all possible ways, within limits, and return the result.

    Args:
        domain: the domain.
        initial: the initial state.
        program: the program.
        goal: the goal.
        limits: the limits of the search.
    """
    return _SubgoalProgramExploration(domain, program, goal, limits).explore_branches(
        SubgoalExecutionBranch(History(initial))
    )


class _SubgoalProgramExploration:
    """The state of one search over all ways to execute a program."""

    def __init__(
        self, domain: Domain, program: SubgoalProgram, goal: GoalProgress, limits: ExplorationLimits
    ) -> None:
        self._domain = domain
        self._program = program
        self._goal = goal
        self._limits = limits
        self._waiting: list[list[SubgoalExecutionBranch]] = [[] for _ in program]
        self._attempts = SearchEffort(limits.attempts)
        self._effort = SearchEffort(limits.effort)
        self._end: ExplorationEnd = "complete"
        self._is_cut = False
        self._successful: list[SubgoalExecutionBranch] = []
        self._executable: list[SubgoalExecutionBranch] = []
        self._failed: list[SubgoalExecutionBranch] = []
        self._ended: list[SubgoalExecutionBranch] = []

    def explore_branches(self, start: SubgoalExecutionBranch) -> ExplorationResult:
        """Explore all ways to execute the subgoals (branches) from a start branch, and return the result."""
        self._waiting[-1].append(start)
        for number in reversed(range(len(self._program))):
            instruction, waiting = self._program[number], self._waiting[number]
            self._waiting[number] = []
            for branch in self._merge_and_limit_branches(waiting, instruction):
                self._execute_instruction(branch, instruction)
                if self._end != "complete":
                    return self._make_result(branch)
        return self._make_result(start)

    def _merge_and_limit_branches(
        self, waiting: list[SubgoalExecutionBranch], instruction: Instruction
    ) -> list[SubgoalExecutionBranch]:
        """Return the branches that execute an instruction next. Branches with the same future are merged.

        The number of branches is limited only before instructions that can make new branches.
        """
        subgoal = _NO_SUBGOAL if instruction is None else instruction.subgoal
        branches = _drop_branches_with_same_future(
            waiting, subgoal, compare_executed_actions=self._goal.trajectory_test is not None
        )
        if not isinstance(instruction, ExecuteSubgoalPlansInstruction | SubgoalForkInstruction):
            return branches
        self._is_cut |= len(branches) > self._limits.branches
        return branches[: self._limits.branches]

    def _make_result(self, unfinished_branch: SubgoalExecutionBranch) -> ExplorationResult:
        if self._is_cut and self._end == "complete" and not self._successful:
            self._end = "branches"
        if self._successful:
            reported = min(self._successful, key=_get_success_sort_key)
        else:
            reported = min(self._executable or self._failed or [unfinished_branch], key=_get_failure_sort_key)
        return ExplorationResult(
            reported=reported,
            success=bool(self._successful),
            executable=bool(self._successful or self._executable),
            end=self._end,
            attempts=self._attempts.used,
            ended=tuple(self._ended),
        )

    def _execute_instruction(self, branch: SubgoalExecutionBranch, instruction: Instruction) -> None:
        match instruction:
            case ExecuteSubgoalPlansInstruction():
                self._execute_subgoal_plans(branch, instruction)
            case CheckSubgoalHoldsInstruction():
                self._continue_branch_only_if_subgoal_holds(branch, instruction)
            case SubgoalForkInstruction(targets):
                self._effort.used += instruction.effort
                for target in targets(branch.state):
                    self._waiting[target].append(branch)
            case None:
                on_course = self._goal.trajectory_test
                reached = self._goal.is_goal_reached_at_end(branch.met, branch.state)
                if reached and on_course is not None:
                    reached = on_course(branch.trajectory)
                self._record_ended_branch(branch, self._successful if reached else self._executable)
            case _:
                assert_never(instruction)

    def _execute_subgoal_plans(
        self, branch: SubgoalExecutionBranch, instruction: ExecuteSubgoalPlansInstruction
    ) -> None:
        if self._has_reached_limit():
            return
        result = instruction.plans(branch.state)
        self._effort.used += result.effort
        if result.failed_check is not None:
            self._record_ended_branch(
                _mark_branch_as_failed(branch, instruction.subgoal, result.failed_check), self._failed
            )
        elif not result.plans:
            self._waiting[instruction.then].append(branch)
        for plan in result.plans:
            if self._has_reached_limit():
                return
            after = self._follow_plan(branch, plan, instruction)
            if after.failure is None:
                self._waiting[instruction.then].append(after)
            else:
                self._record_ended_branch(after, self._failed)

    def _follow_plan(
        self,
        branch: SubgoalExecutionBranch,
        plan: ActionSequence,
        instruction: ExecuteSubgoalPlansInstruction,
    ) -> SubgoalExecutionBranch:
        """Return a branch (one execution of the subgoals), extended by a plan up to the first failing step.

        Additional (needless) steps do not end the branch. If the subgoal needs more than ``max_actions``
        actions, return the branch as failed, without the plan.
        """
        past, tried, errors, met = branch.past, branch.tried, branch.errors, branch.met
        subgoal, most = instruction.subgoal, instruction.max_actions
        executed, refined = branch.count_actions_executed_for_subgoal(subgoal), branch.refined
        for action in plan:
            self._attempts.used += 1
            outcome = attempt_action(self._domain, past, action)
            if isinstance(outcome, State):
                if executed == most:
                    return _mark_branch_as_failed(branch, subgoal, TOO_FAR)
                executed += 1
                refined += executed == 1
                met = self._goal.count_goal_parts_met_after_action(met, past.state, action)
                past, tried = past.extend(outcome), _StepWithPredecessor(Step(action, None), tried)
                continue
            errors += 1
            tried = _StepWithPredecessor(Step(action, outcome), tried)
            if outcome.kind is not FaultKind.ADDITIONAL_STEP:
                self._effort.used += past.number // _PAST_STATES_PER_ACTION
                return SubgoalExecutionBranch(past, tried, errors, met, subgoal, outcome, executed, refined)
        return SubgoalExecutionBranch(past, tried, errors, met, subgoal, None, executed, refined)

    def _continue_branch_only_if_subgoal_holds(
        self, branch: SubgoalExecutionBranch, instruction: CheckSubgoalHoldsInstruction
    ) -> None:
        if self._has_reached_limit():
            return
        self._effort.used += instruction.effort
        if instruction.holds(branch.state):
            self._waiting[instruction.then].append(branch)
            return
        earlier = self._find_index_of_last_satisfying_state(branch, instruction)
        if not self._has_reached_limit():
            failed = _mark_branch_as_failed(branch, instruction.subgoal, instruction.check, earlier)
            self._record_ended_branch(failed, self._failed)

    def _find_index_of_last_satisfying_state(
        self, branch: SubgoalExecutionBranch, instruction: CheckSubgoalHoldsInstruction
    ) -> int | None:
        """Test a subgoal in the past states of a branch. Return the index of the last state in which it held.

        Return None if it never held. If the search reaches a limit meanwhile, not all states are tested. Then
        callers must ignore the index.
        """

        def is_subgoal_met_or_limit_reached(state: State) -> bool:
            self._effort.used += instruction.effort
            return self._has_reached_limit() or instruction.holds(state)

        return branch.past.find_last_state_index(instruction.holds, is_subgoal_met_or_limit_reached)

    def _record_ended_branch(
        self, branch: SubgoalExecutionBranch, branches_with_same_outcome: list[SubgoalExecutionBranch]
    ) -> None:
        self._ended.append(branch)
        branches_with_same_outcome.append(branch)

    def _has_reached_limit(self) -> bool:
        if self._attempts.is_limit_reached:
            self._end = "attempts"
        elif self._effort.is_limit_reached:
            self._end = "effort"
        return self._end != "complete"
