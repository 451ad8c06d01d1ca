"""Exploration of all ways of carrying out a sequence of subgoals, and how far each comes with the goal.

A subgoal can be translated into several plans, and an ``or`` leaves a choice of subgoals; each choice makes a
branch, and all branches are explored. Branches that meet in one state, with the same subgoals left and the
same progress towards the goal, have the same future, so that only the best of them are followed: 2^k choices
do not cost 2^k executions. What is reported is what a search without merging would report. (The states that a
branch has been through can make its last error a wrong order instead of a missing step, but no branch is
preferred for that.)

The goal is a sequence of state formulas, ``f1 then f2 then ...`` (as all goals of the data set are): the
first part is met at the earliest position at which it holds, each further part at the earliest one after
that. An action belongs to the position of the state in which it is taken; the last position has none. So the
number of parts met so far is all that a search has to know of the past. This is `eai.logic.semantics` for
such sequences, step by step (held equal by a test).
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
    Fork,
    Instruction,
    Perform,
    Program,
    Require,
)
from eai.base.errors import InputError
from eai.logic.rewriting import rewrite
from eai.logic.traversal import is_state_formula, walk
from eai.planning.search import Effort
from eai.tasks.goal_test import ACTION_ARGUMENTS, StateTest
from eai.world.action import Action, Fault
from eai.world.domain import Domain
from eai.world.execution import Step, Trajectory, attempt
from eai.world.fault import FaultKind
from eai.world.history import History
from eai.world.operator import Check
from eai.world.state import Scene, State


class _GoalPart:
    """One part of a goal: a formula on a state and the action taken there."""

    __slots__ = ("_actions", "_formula", "_scene", "_test")

    def __init__(self, formula: f.Formula, scene: Scene) -> None:
        self._formula = formula
        self._scene = scene
        self._actions = frozenset([part.action for part in walk(formula) if isinstance(part, f.Occurs)])
        self._test = cache(self._compile)

    def holds(self, state: State, action: Action | None) -> bool:
        """Whether the part holds at a position."""
        if action is None or action.operator not in self._actions:
            return self._test(None)(state)
        return self._test(action.operator)(state, action.arguments)

    def _compile(self, name: str | None) -> StateTest:
        """The part where an action of this name, or none that it mentions, is taken."""
        formula = self._formula
        at_action = rewrite(formula, lambda leaf, _: _fix_action(leaf, name)) if self._actions else formula
        return StateTest(at_action, self._scene)


def _fix_action(leaf: f.Leaf, name: str | None) -> f.Formula:
    """A leaf where the action of this name is taken: its occurrence becomes equality of the objects."""
    if not isinstance(leaf, f.Occurs):
        return leaf
    if leaf.action != name:
        return f.FALSE
    pairs = zip(leaf.arguments, ACTION_ARGUMENTS, strict=False)
    return f.And(tuple(f.Equals(term, argument) for term, argument in pairs))


class GoalProgress:
    """The parts of a goal over a scene.

    Args:
        goal: the parts, to be met one after the other.
        scene: the scene.
        at_end: whether the last state is as it must be besides; None asks for nothing.
        on_course: likewise, of all that happens on a way there.

    Attributes:
        actions: the operators that it asks for.
        on_course: whether the whole course is as it must be; None where it does not matter.

    Raises:
        InputError: the goal is not a sequence of state formulas.
        DomainError: it uses a predicate or an object that there is not.
    """

    def __init__(
        self,
        goal: f.Formula,
        scene: Scene,
        at_end: Callable[[State], bool] | None = None,
        on_course: Callable[[Trajectory], bool] | None = None,
    ) -> None:
        parts = goal.parts if isinstance(goal, f.Then) else (goal,)
        for part in parts:
            if not is_state_formula(part):
                raise InputError("a goal must be a sequence of state formulas, 'f then g then ...'")
        self._parts = tuple(_GoalPart(part, scene) for part in parts)
        self._at_end = at_end
        self.on_course = on_course
        self.actions = frozenset([e.action for part in parts for e in walk(part) if isinstance(e, f.Occurs)])

    def advance(self, met: int, state: State, action: Action) -> int:
        """How many parts are met after a position, of which ``met`` were before it."""
        if met < len(self._parts) and self._parts[met].holds(state, action):
            return met + 1
        return met

    def is_reached(self, met: int, final: State) -> bool:
        """Whether the goal is reached where a trajectory ends; its last state may meet the last part."""
        missing = len(self._parts) - met
        met_by_now = missing == 0 or (missing == 1 and self._parts[-1].holds(final, None))
        return met_by_now and (self._at_end is None or self._at_end(final))


_MIN_BRANCHES_TO_MERGE = 5
"""With fewer branches than this it is cheaper to explore twins than to look for them."""


class _TriedSteps(NamedTuple):
    """A step, and those that were tried before it, which are shared by all branches that begin with them."""

    step: Step
    before: _TriedSteps | None


class Branch(NamedTuple):
    """One way of carrying out the subgoals, so far.

    Attributes:
        past: the initial state, then the state after each executed action.
        tried: every action tried, with its fault if it was not executed.
        errors: the number of faults.
        met: the goal's summary of the branch.
        subgoal: the number of the subgoal that was carried out last.
        failure: the fault that ended the branch.
        executed: how many actions have been executed for that subgoal.
        refined: for how many subgoals actions have been executed.
    """

    past: History
    tried: _TriedSteps | None = None
    errors: int = 0
    met: int = 0
    subgoal: int = 0
    failure: Fault | None = None
    executed: int = 0
    refined: int = 0

    def count_executed(self, subgoal: int) -> int:
        """How many actions have been executed for a subgoal, if it is the last one."""
        return self.executed if self.subgoal == subgoal else 0

    @property
    def state(self) -> State:
        """The last state reached."""
        return self.past.state

    @property
    def steps(self) -> tuple[Step, ...]:
        """Every action tried, in order."""
        found, tried = [], self.tried
        while tried is not None:
            found.append(tried.step)
            tried = tried.before
        return tuple(reversed(found))

    @property
    def trajectory(self) -> Trajectory:
        """The actions that were tried and what came of them."""
        return Trajectory(self.past.states, self.steps)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All faults in order: those of steps, then that of a required subgoal which does not hold."""
        faults = tuple([step.fault for step in self.steps if step.fault is not None])
        if self.failure is None or len(faults) == self.errors:
            return faults
        return (*faults, self.failure)


def _rank_success(branch: Branch) -> int:
    """The rank of a branch that may succeed: the fewest errors first."""
    return branch.errors


def _rank_failure(branch: Branch) -> tuple[int, int]:
    """The rank of a branch that does not reach the goal: of the fewest errors the longest first."""
    return branch.errors, -branch.past.number


def _merge_branches(branches: list[Branch], subgoal: int, *, with_pasts: bool) -> list[Branch]:
    """Of branches with the same future those to report if they succeed, and if they fail; in order.

    They continue with the subgoal of a number. ``with_pasts``: it matters to the goal which way they came.
    """
    if len(branches) < _MIN_BRANCHES_TO_MERGE:
        return branches
    twins: dict[object, list[Branch]] = {}
    for branch in branches:
        way = branch.trajectory.executed if with_pasts else ()
        key = (branch.state, branch.met, branch.count_executed(subgoal), way)
        twins.setdefault(key, []).append(branch)
    best = [(min(each, key=_rank_success), min(each, key=_rank_failure)) for each in twins.values()]
    kept = {id(branch) for pair in best for branch in pair}
    return [branch for branch in branches if id(branch) in kept]


_PAST_STATES_PER_ACTION = 16
"""How many states of the past are looked at in the time in which an action is applied."""


_NO_SUBGOAL = -1
"""The number of no subgoal."""


def _end_branch(branch: Branch, subgoal: int, check: Check, earlier: int | None = None) -> Branch:
    """The branch that ends at a subgoal for which no action is taken, be it that it held earlier."""
    kind = check.fault if earlier is None else FaultKind.WRONG_ORDER
    fault = Fault(kind, check, earlier)
    return branch._replace(errors=branch.errors + 1, subgoal=subgoal, failure=fault)


@dataclass(frozen=True, slots=True)
class ExplorationLimits:
    """How much a search may do.

    Attributes:
        attempts: actions that may be tried, over all branches.
        branches: branches with which any one subgoal may be begun; of more the first are followed. All that
            carry out the last one are tested for the goal.
        effort: actions that may be applied to states to find out what is to be done, over all branches.
    """

    attempts: int = 20_000
    branches: int = 16
    effort: int = 100_000


ExplorationEnd: TypeAlias = Literal["complete", "attempts", "branches", "effort"]
"""Why a search ended: it has seen all, or has come to one of its limits."""


@dataclass(frozen=True, slots=True)
class ExplorationResult:
    """The result of a search.

    Attributes:
        reported: of the branches that reach the goal, or else of those that carry out all subgoals, or else
            of all: the one with the fewest errors; of several the first, or, if none reaches the goal, the
            one with the most actions.
        success: some branch reaches the goal.
        executable: some branch carries out all subgoals.
        end: why the search ended; if not for being complete, ``reported`` is the best of what was seen.
        attempts: the number of actions that were tried.
        ended: all branches that were carried out or failed, in the order found.
    """

    reported: Branch
    success: bool
    executable: bool
    end: ExplorationEnd
    attempts: int
    ended: tuple[Branch, ...] = ()


def search(
    domain: Domain,
    initial: State,
    program: Program,
    goal: GoalProgress,
    limits: ExplorationLimits,
) -> ExplorationResult:
    """Carry out a program of subgoals in all ways.

    Args:
        domain: the world.
        initial: where it begins.
        program: the subgoals.
        goal: what is to be reached.
        limits: how much the search may do.
    """
    return _Exploration(domain, program, goal, limits).run(Branch(History(initial)))


class _Exploration:
    """The state of one search."""

    def __init__(
        self, domain: Domain, program: Program, goal: GoalProgress, limits: ExplorationLimits
    ) -> None:
        self._domain = domain
        self._program = program
        self._goal = goal
        self._limits = limits
        self._waiting: list[list[Branch]] = [[] for _ in program]
        self._attempts = Effort(limits.attempts)
        self._effort = Effort(limits.effort)
        self._end: ExplorationEnd = "complete"
        self._is_cut = False
        self._successful: list[Branch] = []
        self._executable: list[Branch] = []
        self._failed: list[Branch] = []
        self._ended: list[Branch] = []

    def run(self, start: Branch) -> ExplorationResult:
        """Explore all branches."""
        self._waiting[-1].append(start)
        for number in reversed(range(len(self._program))):
            instruction, waiting = self._program[number], self._waiting[number]
            self._waiting[number] = []
            for branch in self._select_branches(waiting, instruction):
                self._run(branch, instruction)
                if self._end != "complete":
                    return self._make_result(branch)
        return self._make_result(start)

    def _select_branches(self, waiting: list[Branch], instruction: Instruction) -> list[Branch]:
        """The branches that continue: all of them with a test that ends a subgoal or the answer."""
        subgoal = _NO_SUBGOAL if instruction is None else instruction.subgoal
        branches = _merge_branches(waiting, subgoal, with_pasts=self._goal.on_course is not None)
        if not isinstance(instruction, Perform | Fork):
            return branches
        self._is_cut |= len(branches) > self._limits.branches
        return branches[: self._limits.branches]

    def _make_result(self, fallback: Branch) -> ExplorationResult:
        if self._is_cut and self._end == "complete" and not self._successful:
            self._end = "branches"
        if self._successful:
            reported = min(self._successful, key=_rank_success)
        else:
            reported = min(self._executable or self._failed or [fallback], key=_rank_failure)
        return ExplorationResult(
            reported=reported,
            success=bool(self._successful),
            executable=bool(self._successful or self._executable),
            end=self._end,
            attempts=self._attempts.used,
            ended=tuple(self._ended),
        )

    def _run(self, branch: Branch, instruction: Instruction) -> None:
        match instruction:
            case Perform():
                self._perform(branch, instruction)
            case Require():
                self._require(branch, instruction)
            case Fork(targets):
                self._effort.used += instruction.effort
                for target in targets(branch.state):
                    self._waiting[target].append(branch)
            case None:
                on_course, reached = self._goal.on_course, self._goal.is_reached(branch.met, branch.state)
                if reached and on_course is not None:
                    reached = on_course(branch.trajectory)
                self._finish(branch, self._successful if reached else self._executable)
            case _:
                assert_never(instruction)

    def _perform(self, branch: Branch, instruction: Perform) -> None:
        if self._is_exhausted():
            return
        found = instruction.plans(branch.state)
        self._effort.used += found.effort
        if found.failed_check is not None:
            self._finish(_end_branch(branch, instruction.subgoal, found.failed_check), self._failed)
        elif not found.plans:
            self._waiting[instruction.then].append(branch)
        for plan in found.plans:
            if self._is_exhausted():
                return
            after = self._follow(branch, plan, instruction)
            if after.failure is None:
                self._waiting[instruction.then].append(after)
            else:
                self._finish(after, self._failed)

    def _follow(self, branch: Branch, plan: ActionSequence, instruction: Perform) -> Branch:
        """The branch after a plan, or after the first step that fails; of too long a plan none is taken."""
        past, tried, errors, met = branch.past, branch.tried, branch.errors, branch.met
        subgoal, most = instruction.subgoal, instruction.max_actions
        executed, refined = branch.count_executed(subgoal), branch.refined
        for action in plan:
            self._attempts.used += 1
            outcome = attempt(self._domain, past, action)
            if isinstance(outcome, State):
                if executed == most:
                    return _end_branch(branch, subgoal, TOO_FAR)
                executed += 1
                refined += executed == 1
                met = self._goal.advance(met, past.state, action)
                past, tried = past.extended(outcome), _TriedSteps(Step(action, None), tried)
                continue
            errors += 1
            tried = _TriedSteps(Step(action, outcome), tried)
            if outcome.kind is not FaultKind.ADDITIONAL_STEP:
                self._effort.used += past.number // _PAST_STATES_PER_ACTION
                return Branch(past, tried, errors, met, subgoal, outcome, executed, refined)
        return Branch(past, tried, errors, met, subgoal, None, executed, refined)

    def _require(self, branch: Branch, instruction: Require) -> None:
        if self._is_exhausted():
            return
        self._effort.used += instruction.effort
        if instruction.holds(branch.state):
            self._waiting[instruction.then].append(branch)
            return
        earlier = self._find_earlier(branch, instruction)
        if not self._is_exhausted():
            failed = _end_branch(branch, instruction.subgoal, instruction.check, earlier)
            self._finish(failed, self._failed)

    def _find_earlier(self, branch: Branch, instruction: Require) -> int | None:
        """The number of the latest state in which what is required held; any where that takes too long."""

        def held(state: State) -> bool:
            self._effort.used += instruction.effort
            return self._is_exhausted() or instruction.holds(state)

        return branch.past.last_where(instruction.holds, held)

    def _finish(self, branch: Branch, among: list[Branch]) -> None:
        """A branch has come to its end, as one of its kind."""
        self._ended.append(branch)
        among.append(branch)

    def _is_exhausted(self) -> bool:
        if self._attempts.is_used_up:
            self._end = "attempts"
        elif self._effort.is_used_up:
            self._end = "effort"
        return self._end != "complete"
