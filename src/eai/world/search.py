"""Planning by search on a declared domain: a plan that takes some actions in order and makes conditions hold.

Greedy best-first search: the state that looks nearest to the goal is expanded next, by its helpful actions
(see `regression`). If those lead nowhere, every possible action on the given objects is tried. All actions of
a plan are possible without any fault. Effort is bounded by a number of states, and by time if that is asked.
"""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple, TypeAlias

from eai.logic.formula import Formula
from eai.world.domain import Domain
from eai.world.execution import Action
from eai.world.regression import INFINITE, Distances, Regression, possible_actions
from eai.world.state import State


@dataclass(frozen=True, slots=True)
class PlanningGoal:
    """What a plan is for.

    Attributes:
        conditions: closed state formulas that shall hold at the end.
        actions: operators to be taken, one after the other, with whatever objects; each entry lists
            alternatives.
    """

    conditions: tuple[Formula, ...]
    actions: tuple[tuple[str, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class PlanningLimits:
    """How much a search may do.

    Attributes:
        states: states that may be reached and estimated.
        seconds: time it may take; None is no limit.
        clock: tells the time in seconds.
    """

    states: int = 1_000
    seconds: float | None = None
    clock: Callable[[], float] = time.monotonic


class PlanningEnd(str, Enum):
    """How a search ended."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    """No state that can be reached by actions on the given objects is a goal, or by the estimate no action at
    all leads to a part of the goal."""
    STATES = "states"
    TIME = "time"


@dataclass(frozen=True, slots=True)
class Planned:
    """What a search found.

    Attributes:
        end: how it ended.
        plan: the plan, if it was solved.
        states: how many states were estimated.
        blocked: if it was not, the conditions and actions that looked out of reach from the initial state.
    """

    end: PlanningEnd
    plan: tuple[Action, ...] = ()
    states: int = 0
    blocked: tuple[Formula | tuple[str, ...], ...] = ()


CarryOut: TypeAlias = Callable[[Action, State], Sequence[Action]]


_STEP_COST = 0.2
"""What a step of the way counts beside an estimated one of the way ahead: enough to leave long detours."""


class _Node(NamedTuple):
    """A state that was reached, with the number of action goals taken on the way, and the way."""

    state: State
    taken: int
    depth: int
    parent: _Node | None
    action: Action | None


def alone(action: Action, state: State) -> tuple[Action, ...]:
    """An action is carried out by itself."""
    return (action,)


class Planner:
    """Searches for plans in one domain.

    Args:
        domain: the domain.
        carry_out: what is done when an action is chosen in a state: a fixed sequence around it, say, where
            plans are not made of single actions. An empty sequence means that it cannot be chosen. A step of
            `Planned.plan` is an action that was chosen.
    """

    def __init__(self, domain: Domain, carry_out: CarryOut = alone) -> None:
        self._domain = domain
        self._carry_out = carry_out
        self._regression = Regression(domain)

    def plan(
        self,
        initial: State,
        goal: PlanningGoal,
        objects: Sequence[int],
        limits: PlanningLimits | None = None,
    ) -> Planned:
        """Look for a plan.

        Args:
            initial: the state to start from.
            goal: what to achieve.
            objects: what actions may be about, by index.
            limits: how much to do.
        """
        search = _Search(
            self._domain, self._regression, self._carry_out, goal, objects, limits or PlanningLimits()
        )
        return search.run(initial)


class _Search:
    """The state of one search."""

    def __init__(
        self,
        domain: Domain,
        regression: Regression,
        carry_out: CarryOut,
        goal: PlanningGoal,
        objects: Sequence[int],
        limits: PlanningLimits,
    ) -> None:
        self._domain = domain
        self._regression = regression
        self._carry_out = carry_out
        self._goal = goal
        self._objects = objects
        self._limits = limits
        self._deadline = None if limits.seconds is None else limits.clock() + limits.seconds
        self._seen: set[tuple[State, int]] = set()
        self._queue: list[tuple[float, int, _Node, tuple[Action, ...]]] = []
        self._later: list[tuple[float, int, _Node]] = []
        self._states = 0

    def run(self, initial: State) -> Planned:
        """Search until there is a plan, nothing is left, or the limits are reached."""
        solution = self._reach(_Node(initial, 0, 0, None, None))
        blocked = () if solution else self._blocked(initial)
        while solution is None:
            if self._states >= self._limits.states:
                return Planned(PlanningEnd.STATES, states=self._states, blocked=blocked)
            if self._deadline is not None and self._limits.clock() > self._deadline:
                return Planned(PlanningEnd.TIME, states=self._states, blocked=blocked)
            step = self._next()
            if step is None:
                return Planned(PlanningEnd.UNREACHABLE, states=self._states, blocked=blocked)
            solution = self._expand(*step)
        return Planned(PlanningEnd.SOLVED, self._without_detours(initial, _plan(solution)), self._states)

    def _reach(self, node: _Node) -> _Node | None:
        """Estimate a state that was reached and queue it; the node itself if the goal is reached in it."""
        key = (node.state, node.taken)
        if key in self._seen:
            return None
        self._seen.add(key)
        self._states += 1
        distances = Distances(self._regression, node.state, self._objects)
        total = 0.0
        helpful: dict[Action, None] = {}
        for condition in self._goal.conditions:
            cost = distances.to(condition)
            total += cost
            if 0.0 < cost < INFINITE:
                helpful.update(distances.helpful(condition))
        for names in self._goal.actions[node.taken :]:
            way = distances.to_action(names)
            total += way.cost
            helpful.update(distances.helpful_on(way))
        if total == 0.0:
            return node
        rank = total + _STEP_COST * node.depth
        heapq.heappush(self._queue, (rank, -self._states, node, tuple(helpful)))
        return None

    def _next(self) -> tuple[_Node, tuple[Action, ...]] | None:
        """What to expand next: a state by its helpful actions, or else an expanded one by all others."""
        if self._queue:
            total, number, node, helpful = heapq.heappop(self._queue)
            heapq.heappush(self._later, (total, number, node))
            return node, helpful
        if not self._later:
            return None
        _, _, node = heapq.heappop(self._later)
        possible = (
            action
            for operator in self._domain.operators
            for action in possible_actions(self._domain, operator, node.state, self._objects)
        )
        return node, tuple(possible)

    def _expand(self, node: _Node, actions: Sequence[Action]) -> _Node | None:
        for action in actions:
            after = self._after(node, action)
            solution = None if after is None else self._reach(after)
            if solution is not None:
                return solution
        return None

    def _after(self, node: _Node, action: Action) -> _Node | None:
        """The node after an action is chosen, or None if it cannot be carried out without a fault."""
        state, taken = node.state, node.taken
        steps = self._carry_out(action, state)
        for step in steps:
            compiled = self._domain.compiled[step.operator]
            binding = compiled.bind(state, step.arguments)
            if compiled.first_failure(state, binding) is not None:
                return None
            if taken < len(self._goal.actions) and step.operator in self._goal.actions[taken]:
                taken += 1
            state = compiled.apply(state, binding)
        return _Node(state, taken, node.depth + 1, node, action) if steps else None

    def _without_detours(self, initial: State, plan: list[Action]) -> tuple[Action, ...]:
        """The plan without actions that it can do without (action elimination, Nakhost and Mueller 2010).

        Each action in turn is left out, and with it those after it that are impossible then.
        """
        position = 0
        while position < len(plan):
            node = _Node(initial, 0, 0, None, None)
            for i, action in enumerate(plan):
                after = self._after(node, action) if i != position else None
                node = node if after is None else after
            if self._is_reached(node):
                plan = _plan(node)
            else:
                position += 1
        return tuple(plan)

    def _is_reached(self, node: _Node) -> bool:
        holds = self._regression.readings.holds
        conditions = self._goal.conditions
        return node.taken == len(self._goal.actions) and all(holds(c, {}, node.state) for c in conditions)

    def _blocked(self, initial: State) -> tuple[Formula | tuple[str, ...], ...]:
        distances = Distances(self._regression, initial, self._objects)
        conditions = (c for c in self._goal.conditions if distances.to(c) == INFINITE)
        actions = (names for names in self._goal.actions if distances.to_action(names).cost == INFINITE)
        return (*conditions, *actions)


def _plan(node: _Node) -> list[Action]:
    """The actions that led to a node."""
    actions: list[Action] = []
    current: _Node | None = node
    while current is not None and current.action is not None:
        actions.append(current.action)
        current = current.parent
    return actions[::-1]
