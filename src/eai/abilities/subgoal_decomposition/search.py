"""Exploration of all ways of carrying out a sequence of subgoals.

A subgoal can be translated into several plans, and an ``or`` leaves a choice of subgoals; each choice makes a
branch, and all branches are explored. Branches that meet in one state, with the same subgoals left and the
same progress towards the goal, have the same future, so that only the best of them are followed: 2^k choices
do not cost 2^k executions. What is reported is what a search without merging would report. (The states that a
branch has been through can make its last error a wrong order instead of a missing step, but no branch is
preferred for that.)
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from typing_extensions import assert_never

from eai.abilities.subgoal_decomposition.branch import BestBranch, Branch, Tried, without_twins
from eai.abilities.subgoal_decomposition.program import (
    TOO_FAR,
    Do,
    End,
    Held,
    Instruction,
    Plan,
    Program,
    Require,
    Split,
)
from eai.planning.search import Effort
from eai.world.domain import Domain
from eai.world.execution import Action, Fault, Step, attempt
from eai.world.fault import FaultKind
from eai.world.operator import Check
from eai.world.past import Past
from eai.world.state import State

_LOOKED_AT_ONCE = 16
"""How many states of the past are looked at in the time in which an action is applied."""


_NONE = -1
"""The number of no subgoal."""


def _refused(branch: Branch, instruction: Do, check: Check) -> Branch:
    """The branch that ends at a subgoal for which no action is taken."""
    fault = Fault(check.fault, check)
    return branch._replace(errors=branch.errors + 1, subgoal=instruction.subgoal, failure=fault)


class _BranchGoal(Protocol):
    """The goal of a branch, as far as its past can be summed up in a number."""

    def advance(self, met: int, state: State, action: Action) -> int:
        """The summary after an action was taken in a state."""
        ...

    def reached(self, met: int, final: State) -> bool:
        """Whether a branch that ends in this state has reached the goal."""
        ...


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


class ExplorationEnd(str, Enum):
    """Why a search ended."""

    COMPLETE = "complete"
    ATTEMPTS = "attempts"
    BRANCHES = "branches"
    EFFORT = "effort"


@dataclass(frozen=True, slots=True)
class Outcome:
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
    domain: Domain, initial: State, program: Program, goal: _BranchGoal, limits: ExplorationLimits
) -> Outcome:
    """Carry out a program of subgoals in all ways."""
    return _Search(domain, program, goal, limits).run(Branch(Past(initial)))


class _Search:
    """The state of one search."""

    def __init__(
        self, domain: Domain, program: Program, goal: _BranchGoal, limits: ExplorationLimits
    ) -> None:
        self._domain = domain
        self._program = program
        self._goal = goal
        self._limits = limits
        self._waiting: list[list[Branch]] = [[] for _ in program]
        self._attempts = Effort(limits.attempts)
        self._effort = Effort(limits.effort)
        self._end = ExplorationEnd.COMPLETE
        self._is_cut = False
        self._successful = BestBranch(longer=False)
        self._executable = BestBranch(longer=True)
        self._failed = BestBranch(longer=True)
        self._ended: list[Branch] = []

    def run(self, start: Branch) -> Outcome:
        """Explore all branches."""
        self._waiting[-1].append(start)
        for number in reversed(range(len(self._program))):
            instruction, waiting = self._program[number], self._waiting[number]
            self._waiting[number] = []
            for branch in self._followed(waiting, instruction):
                self._go_on(branch, instruction)
                if self._end is not ExplorationEnd.COMPLETE:
                    return self._outcome(branch)
        return self._outcome(start)

    def _followed(self, waiting: list[Branch], instruction: Instruction) -> list[Branch]:
        """The branches that go on with an instruction: all with a test that ends a subgoal or the answer."""
        match instruction:
            case Do() | Held() | Split():
                branches = without_twins(waiting, instruction.subgoal)
                self._is_cut |= len(branches) > self._limits.branches
                return branches[: self._limits.branches]
            case Require():
                return without_twins(waiting, instruction.subgoal)
            case _:
                return without_twins(waiting, _NONE)

    def _outcome(self, fallback: Branch) -> Outcome:
        if self._is_cut and self._end is ExplorationEnd.COMPLETE and self._successful.branch is None:
            self._end = ExplorationEnd.BRANCHES
        best = (self._successful.branch, self._executable.branch, self._failed.branch, fallback)
        return Outcome(
            reported=next(filter(None, best)),
            success=self._successful.branch is not None,
            executable=self._successful.branch is not None or self._executable.branch is not None,
            end=self._end,
            attempts=self._attempts.used,
            ended=tuple(self._ended),
        )

    def _go_on(self, branch: Branch, instruction: Instruction) -> None:
        match instruction:
            case Do():
                self._do(branch, instruction)
            case Require():
                self._require(branch, instruction)
            case Held():
                self._effort.used += instruction.effort
                held = instruction.holds(branch.state)
                self._waiting[instruction.then if held else instruction.otherwise].append(branch)
            case Split(targets):
                for target in targets:
                    self._waiting[target].append(branch)
            case End():
                reached = self._goal.reached(branch.met, branch.state)
                self._finish(branch, self._successful if reached else self._executable)
            case _:
                assert_never(instruction)

    def _do(self, branch: Branch, instruction: Do) -> None:
        if self._is_exhausted():
            return
        found = instruction.plans(branch.state)
        self._effort.used += found.effort
        if found.refused is not None:
            self._finish(_refused(branch, instruction, found.refused), self._failed)
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

    def _follow(self, branch: Branch, plan: Plan, instruction: Do) -> Branch:
        """The branch after a plan, or after the first step that fails; of too long a plan none is taken."""
        past, tried, errors, met = branch.past, branch.tried, branch.errors, branch.met
        subgoal, most = instruction.subgoal, instruction.most
        executed, refined = branch.executed_for(subgoal), branch.refined
        for action in plan:
            self._attempts.used += 1
            outcome = attempt(self._domain, past, action)
            if isinstance(outcome, State):
                if executed == most:
                    return _refused(branch, instruction, TOO_FAR)
                executed += 1
                refined += executed == 1
                met = self._goal.advance(met, past.state, action)
                past, tried = past.then(outcome), Tried(Step(action, None), tried)
                continue
            errors += 1
            tried = Tried(Step(action, outcome), tried)
            if outcome.kind is not FaultKind.ADDITIONAL_STEP:
                self._effort.used += past.number // _LOOKED_AT_ONCE
                return Branch(past, tried, errors, met, subgoal, outcome, executed, refined)
        return Branch(past, tried, errors, met, subgoal, None, executed, refined)

    def _require(self, branch: Branch, instruction: Require) -> None:
        if self._is_exhausted():
            return
        self._effort.used += instruction.effort
        if instruction.holds(branch.state):
            self._waiting[instruction.then].append(branch)
            return
        check, earlier = instruction.check, self._held_before(branch, instruction)
        if self._is_exhausted():
            return
        fault = Fault(check.fault, check)
        if earlier is not None:
            fault = Fault(FaultKind.WRONG_ORDER, check, earlier)
        failed = branch._replace(errors=branch.errors + 1, subgoal=instruction.subgoal, failure=fault)
        self._finish(failed, self._failed)

    def _held_before(self, branch: Branch, instruction: Require) -> int | None:
        """The number of the latest state in which what is required held; any where that takes too long."""

        def held(state: State) -> bool:
            self._effort.used += instruction.effort
            return self._is_exhausted() or instruction.holds(state)

        return branch.past.latest(instruction.holds, held)

    def _finish(self, branch: Branch, among: BestBranch) -> None:
        """A branch has come to its end, and may be the best of its kind."""
        self._ended.append(branch)
        among.offer(branch)

    def _is_exhausted(self) -> bool:
        if self._attempts.is_used_up:
            self._end = ExplorationEnd.ATTEMPTS
        elif self._effort.is_used_up:
            self._end = ExplorationEnd.EFFORT
        return self._end is not ExplorationEnd.COMPLETE
