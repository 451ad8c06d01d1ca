"""Branches of a search: ways of carrying out the subgoals of an answer, and which of them are the best."""

from __future__ import annotations

from typing import NamedTuple

from eai.world.execution import Fault, Step, Trajectory
from eai.world.state import State

_FEW = 5
"""With fewer branches than this it is cheaper to explore twins than to look for them."""


class Branch(NamedTuple):
    """One way of carrying out the subgoals, so far.

    Attributes:
        states: the initial state, then the state after each executed action.
        steps: every action tried, in order, with its fault if it was not executed.
        errors: the number of faults.
        met: the goal's summary of the branch.
        subgoal: the number of the subgoal that was carried out last.
        failure: the fault that ended the branch.
    """

    states: tuple[State, ...]
    steps: tuple[Step, ...] = ()
    errors: int = 0
    met: int = 0
    subgoal: int = 0
    failure: Fault | None = None

    @property
    def trajectory(self) -> Trajectory:
        """What was tried and what came of it."""
        return Trajectory(self.states, self.steps)

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
        return branch.errors, -len(branch.states) if self._longer else 0


def without_twins(branches: list[Branch]) -> list[Branch]:
    """Of branches with the same future those to report if they succeed, and if they fail; in order."""
    if len(branches) < _FEW:
        return branches
    best: dict[tuple[State, int], tuple[BestBranch, BestBranch]] = {}
    for branch in branches:
        key = (branch.states[-1], branch.met)
        if key not in best:
            best[key] = (BestBranch(longer=False), BestBranch(longer=True))
        for each in best[key]:
            each.offer(branch)
    kept = {id(each.branch) for pair in best.values() for each in pair}
    return [branch for branch in branches if id(branch) in kept]
