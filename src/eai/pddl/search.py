"""A small forward search, which decides most problems of this package without an outside planner.

Greedy best-first search with deferred evaluation, guided by the length of a relaxed plan (Hoffmann and
Nebel 2001); the first actions of the relaxed plan are preferred, and all the more after progress (Helmert
2006, Richter and Helmert 2009); then relaxed planning is also carried out, and the state that it leads to
comes next (`lookahead`). What of the operators cannot matter is left out (`relevance`). First only actions on
the objects that the goal is about are tried, then all; a search that takes long asks whether the goal is
possible at all (`pairs`). Effort is bounded by a number of evaluated states and not by a clock, so that equal
input gives an equal answer on every machine.
"""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from eai.pddl.execute import PlanStep
from eai.pddl.grounding import GroundAction, GroundCondition, Grounder
from eai.pddl.literals import Literals
from eai.pddl.lookahead import Lookahead
from eai.pddl.model import PddlDomain, PddlProblem
from eai.pddl.pairs import Pairs
from eai.pddl.relaxation import Relaxation
from eai.pddl.relevance import relevant
from eai.pddl.successors import Successors
from eai.planning.effort import Effort

_DOUBT = 60
"""After how many evaluated states it is asked whether the goal's literals may hold together at all."""

_BOOST = 1000
"""How many preferred states are taken before any other after a state that is nearer to the goal than all
before."""


class SearchVerdict(str, Enum):
    """What the search found out."""

    SOLVED = "solved"
    UNSOLVABLE = "unsolvable"
    UNDECIDED = "undecided"


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The verdict, the plan if there is one, and the number of states that were evaluated."""

    verdict: SearchVerdict
    plan: tuple[PlanStep, ...] = ()
    evaluated: int = 0


@dataclass(frozen=True, slots=True)
class GroundLimits:
    """How much may be done, counted and never timed.

    On the gold operators the default leaves no problem undecided; of the operators of nine models none is
    too large for it.

    Attributes:
        central: how many states may be evaluated with actions on the goal's objects only.
        full: how many with all actions.
        size: how many objects may be looked at to ground operators and goal.
        looks: how many literals, options and effects may be looked at, in all states together;
            no problem of nine models' operators that is decided needs 400,000.
    """

    central: int = 60
    full: int = 2_000
    size: int = 50_000
    looks: int = 700_000


def search(domain: PddlDomain, problem: PddlProblem, limits: GroundLimits) -> SearchResult:
    """Look for a plan.

    `SearchVerdict.UNSOLVABLE` is a proof: the goal is out of reach even if nothing is ever lost, or two of
    its literals never hold together, or the whole state space was searched. What is too large to be grounded
    is undecided.
    """
    looks = Effort(limits.size)
    grounder = Grounder(relevant(domain, problem), problem, looks)
    goal = grounder.goal()
    if goal is None and not looks.is_exceeded:
        return SearchResult(SearchVerdict.UNSOLVABLE)
    objects = grounder.central_objects()
    central, all_are_central = list(grounder.actions(objects)), objects >= grounder.objects
    if goal is None or looks.is_exceeded:
        return SearchResult(SearchVerdict.UNDECIDED)
    work, limit = Effort(limits.looks), limits.full if all_are_central else limits.central
    result = _Search(central, goal, grounder.atoms, work).run(grounder.initial, limit)
    if result.verdict is SearchVerdict.SOLVED or all_are_central:
        return result
    everything = list(grounder.actions())
    if looks.is_exceeded:
        return SearchResult(SearchVerdict.UNDECIDED, evaluated=result.evaluated)
    return _Search(everything, goal, grounder.atoms, work).run(grounder.initial, limits.full)


@dataclass(frozen=True, slots=True)
class _Node:
    """A state with the way to it."""

    state: int
    action: GroundAction | None
    parent: _Node | None

    def plan(self) -> tuple[PlanStep, ...]:
        steps: list[PlanStep] = []
        node: _Node | None = self
        while node is not None and node.action is not None:
            steps.append(node.action.step)
            node = node.parent
        return tuple(reversed(steps))


_Entry = tuple[int, int, _Node]
"""Estimate of the state before, what orders equal ones (the last to arrive is the first), the state."""


@dataclass(slots=True)
class _Frontier:
    """The states to be evaluated: all of them, and once more those that a preferred action leads to."""

    everything: list[_Entry] = field(default_factory=list)
    preferred: list[_Entry] = field(default_factory=list)
    taken_from_everything: int = 0
    taken_from_preferred: int = 0
    arrivals: int = 0

    def push(self, estimate: int, node: _Node, *, preferred: bool) -> None:
        self.arrivals += 1
        entry = (estimate, -self.arrivals, node)
        heapq.heappush(self.everything, entry)
        if preferred:
            heapq.heappush(self.preferred, entry)

    def pop(self) -> _Node | None:
        """The next state; one that is in both heaps comes twice."""
        if self.preferred and self.taken_from_preferred < self.taken_from_everything:
            self.taken_from_preferred += 1
            return heapq.heappop(self.preferred)[2]
        if self.everything:
            self.taken_from_everything += 1
            return heapq.heappop(self.everything)[2]
        return None

    def boost(self) -> None:
        self.taken_from_preferred -= _BOOST


class _Search:
    """One search over one set of ground actions."""

    def __init__(
        self, actions: Sequence[GroundAction], goal: GroundCondition, atoms: int, looks: Effort
    ) -> None:
        self._literals = Literals(atoms, looks)
        self._relaxation = Relaxation(actions, goal, self._literals, looks)
        self._successors = Successors(actions, self._literals, looks)
        self._actions = actions
        self._goal = self._literals.needs(goal)
        self._condition = goal
        self._looks = looks

    def run(self, initial: int, limit: int) -> SearchResult:
        frontier = _Frontier()
        seen, done = {initial}, set[int]()
        best: int | None = None
        node: _Node | None = _Node(initial, None, None)
        while node is not None:
            literals = self._literals.of(node.state)
            if not self._goal & ~literals:
                return SearchResult(SearchVerdict.SOLVED, node.plan(), len(done))
            if len(done) == limit or self._looks.is_exceeded:
                return SearchResult(SearchVerdict.UNDECIDED, evaluated=len(done))
            if len(done) == _DOUBT and not self._goal_is_consistent(initial):
                break
            done.add(node.state)
            ahead = node
            estimate = self._relaxation.estimate(node.state, literals)
            if estimate is not None:
                if best is None or estimate.length < best:
                    best = estimate.length
                    frontier.boost()
                    ahead = self._ahead(node, literals)
                for action, state in self._successors.of(node.state, literals):
                    if state not in seen:
                        seen.add(state)
                        child = _Node(state, self._actions[action.bit_length() - 1], node)
                        frontier.push(estimate.length, child, preferred=bool(action & estimate.helpful))
            seen.add(ahead.state)
            node = ahead if ahead.state not in done else _next(frontier, done)
        verdict = SearchVerdict.UNDECIDED if self._looks.is_exceeded else SearchVerdict.UNSOLVABLE
        return SearchResult(verdict, evaluated=len(done))

    def _goal_is_consistent(self, initial: int) -> bool:
        """Whether the goal may hold in a state that actions lead to, as far as pairs of literals tell."""
        pairs = Pairs(self._actions, self._literals.atoms, initial, self._looks)
        return pairs.allow(self._condition)

    def _ahead(self, node: _Node, literals: int) -> _Node:
        """Where carrying out the relaxed plan leads."""
        lookahead = Lookahead(self._relaxation, self._successors, self._literals, self._goal)
        for action, state in lookahead.towards(node.state, literals):
            node = _Node(state, self._actions[action], node)
        return node


def _next(frontier: _Frontier, done: set[int]) -> _Node | None:
    while (node := frontier.pop()) is not None:
        if node.state not in done:
            return node
    return None
