"""Branches of a search: ways of carrying out the subgoals of an answer, and which of them are the best."""

from __future__ import annotations

from typing import NamedTuple

from eai.world.execution import Fault, Step, Trajectory
from eai.world.past import Past
from eai.world.state import State

_FEW = 5
"""With fewer branches than this it is cheaper to explore twins than to look for them."""


class Tried(NamedTuple):
    """A step, and those that were tried before it, which are shared by all branches that begin with them."""

    step: Step
    before: Tried | None


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

    past: Past
    tried: Tried | None = None
    errors: int = 0
    met: int = 0
    subgoal: int = 0
    failure: Fault | None = None
    executed: int = 0
    refined: int = 0

    def executed_for(self, subgoal: int) -> int:
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


class BestBranch:
    """The best branch seen so far; of equal ones the longer is better, if that is asked, then the first."""

    __slots__ = ("_longer", "branch")

    def __init__(self, *, longer: bool) -> None:
        self._longer = longer
        self.branch: Branch | None = None

    def offer(self, branch: Branch) -> None:
        """See one more branch."""
        if self.branch is None or self._rank(branch) < self._rank(self.branch):
            self.branch = branch

    def _rank(self, branch: Branch) -> tuple[int, int]:
        return branch.errors, -branch.past.number if self._longer else 0


def without_twins(branches: list[Branch], subgoal: int) -> list[Branch]:
    """Of branches with the same future those to report if they succeed, and if they fail; in order.

    They go on with the subgoal of a number.
    """
    if len(branches) < _FEW:
        return branches
    best: dict[tuple[State, int, int], tuple[BestBranch, BestBranch]] = {}
    for branch in branches:
        key = (branch.state, branch.met, branch.executed_for(subgoal))
        if key not in best:
            best[key] = (BestBranch(longer=False), BestBranch(longer=True))
        for each in best[key]:
            each.offer(branch)
    kept = {id(each.branch) for pair in best.values() for each in pair}
    return [branch for branch in branches if id(branch) in kept]
