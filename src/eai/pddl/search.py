"""A small forward search that decides most planning problems of this package's size without an outside
planner.

Greedy best-first search with deferred evaluation, guided by the length of a relaxed plan (Hoffmann and
Nebel 2001), whose first actions are preferred (Helmert 2006). First only actions on the objects that the
goal is about are tried, then all. Effort is bounded by the number of evaluated states and not by a clock,
so that equal input gives an equal answer on every machine.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from eai.pddl.execute import Step
from eai.pddl.grounding import Condition, GroundAction, Grounder
from eai.pddl.model import Domain, Problem
from eai.pddl.relaxation import Relaxation


class Verdict(str, Enum):
    """What the search found out."""

    SOLVED = "solved"
    UNSOLVABLE = "unsolvable"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The verdict, the plan if there is one, and the number of states that were evaluated."""

    verdict: Verdict
    plan: tuple[Step, ...] = ()
    evaluated: int = 0


@dataclass(frozen=True, slots=True)
class Effort:
    """How many states may be evaluated with the goal's objects only, and with all objects."""

    central: int = 60
    full: int = 200


def search(domain: Domain, problem: Problem, effort: Effort) -> SearchResult:
    """Look for a plan.

    `Verdict.UNSOLVABLE` is a proof: no state reachable even without deletions has the goal, or the whole
    state space was searched.
    """
    grounder = Grounder(domain, problem)
    goal = grounder.goal()
    if goal is None:
        return SearchResult(Verdict.UNSOLVABLE)
    central = list(grounder.actions(grounder.central_objects()))
    first = _search(central, grounder.initial, goal, effort.central)
    if first.verdict is Verdict.SOLVED:
        return first
    everything = list(grounder.actions())
    if len(everything) == len(central):
        return _search(everything, grounder.initial, goal, effort.full)
    return _search(everything, grounder.initial, goal, effort.full)


@dataclass(frozen=True, slots=True)
class _Node:
    """A state with the way to it."""

    state: int
    action: GroundAction | None
    parent: _Node | None

    def plan(self) -> tuple[Step, ...]:
        steps: list[Step] = []
        node: _Node | None = self
        while node is not None and node.action is not None:
            steps.append(node.action.step)
            node = node.parent
        return tuple(reversed(steps))


def _search(actions: Sequence[GroundAction], initial: int, goal: Condition, limit: int) -> SearchResult:
    relaxation = Relaxation(actions, goal)
    start = relaxation.estimate(initial)
    if start is None:
        return SearchResult(Verdict.UNSOLVABLE, evaluated=1)
    reachable = relaxation.reachable(initial)
    frontier: list[tuple[int, int, int, _Node]] = [(0, 0, 0, _Node(initial, None, None))]
    seen = {initial}
    pushed = evaluated = 0
    while frontier:
        node = heapq.heappop(frontier)[3]
        if goal.holds(node.state):
            return SearchResult(Verdict.SOLVED, node.plan(), evaluated)
        if evaluated == limit:
            return SearchResult(Verdict.UNDECIDED, evaluated=evaluated)
        evaluated += 1
        estimate = relaxation.estimate(node.state)
        if estimate is None:
            continue
        for action in reachable:
            if not action.precondition.holds(node.state):
                continue
            state = action.successor(node.state)
            if state in seen:
                continue
            seen.add(state)
            pushed += 1
            dispreferred = action.step not in estimate.helpful
            entry = (estimate.length, int(dispreferred), pushed, _Node(state, action, node))
            heapq.heappush(frontier, entry)
    return SearchResult(Verdict.UNSOLVABLE, evaluated=evaluated)
