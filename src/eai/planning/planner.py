"""Planning by search on a declared domain: a plan that takes some actions in order and makes conditions hold.

The goals are reached one after the other (`agenda`), each by greedy best-first search (`best_first`) that is
guided by the additive heuristic, computed backwards from the goal (`additive_heuristic`). Where no goal can
be reached without giving up another one, all are searched for together. All actions of a plan are applicable.
Effort is bounded by a number of states, never by time: equal input gives equal output.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from eai.logic.formula import Formula
from eai.planning.action_elimination import without_needless_actions
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, Estimates
from eai.planning.agenda import Agenda
from eai.planning.best_first import BestFirst, Budget, Target
from eai.planning.subgoal import Subgoal, conjuncts
from eai.planning.successor_generator import CarryOut, Node, SuccessorGenerator
from eai.world.domain import Domain
from eai.world.execution import Action
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
        thorough: whether goals are tried in another order, and actions that do not look promising are taken,
            when nothing else is left. Where they are not, nothing is said of what looks out of reach.
    """

    states: int = 2_000
    thorough: bool = True


class PlanningEnd(str, Enum):
    """How a search ended."""

    SOLVED = "solved"
    UNREACHABLE = "unreachable"
    """No state that can be reached by actions on the given objects is a goal."""
    STATES = "states"
    """A limit was reached."""


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


_FIRST_BUDGET = Budget(50, complete=False)
"""What is spent on reaching one goal, at first."""

_MORE = 4
"""How many times as much is spent after all have failed."""


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
        self._heuristic = AdditiveHeuristic(domain)

    def holds(self, condition: Formula, state: State) -> bool:
        """Whether a closed condition holds in a state. It is read once, and kept as long as the planner."""
        return self._heuristic.readings.holds(condition, {}, state)

    def looks_reachable(self, state: State, condition: Formula, objects: Sequence[int]) -> bool:
        """Whether a closed condition may be brought about by actions on some objects, as is told at once.

        That it looks out of reach is no proof that it is; but no search is spent on it.
        """
        estimates = Estimates(self._heuristic, state, objects)
        return estimates.to(Subgoal(condition, {}, True)) < INFINITE

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
        successors = SuccessorGenerator(self._domain, self._carry_out, objects, goal.actions)
        return _PlanSearch(self._heuristic, successors, goal, limits or PlanningLimits()).run(Node(initial))


class _PlanSearch:
    """The state of one search."""

    def __init__(
        self,
        heuristic: AdditiveHeuristic,
        successors: SuccessorGenerator,
        goal: PlanningGoal,
        limits: PlanningLimits,
    ) -> None:
        self._heuristic = heuristic
        self._successors = successors
        self._goal = goal
        self._search = BestFirst(heuristic, successors, limits.states)
        self._limits = limits

    def run(self, start: Node) -> Planned:
        """Search until there is a plan, nothing is left, or the limits are reached."""
        subgoals = [Subgoal(condition, {}, True) for condition in self._goal.conditions]
        goals = tuple([goal for each in subgoals for goal in conjuncts(each, start.state.scene)])
        agenda = Agenda(self._heuristic, self._successors, self._search, goals)
        everything = Target(goals, len(self._goal.actions))
        node, budget = start, _FIRST_BUDGET
        while not self._is_reached(node):
            further = agenda.advance(node, budget)
            if self._search.effort.is_used_up:
                return self._failed(PlanningEnd.STATES, start)
            if further is not None:
                node, budget = further, _FIRST_BUDGET
            elif not self._limits.thorough:
                return Planned(PlanningEnd.STATES, (), self._search.effort.used)
            elif agenda.learn():
                node, budget = start, _FIRST_BUDGET
            else:
                budget = Budget(_MORE * budget.states, complete=True)
                found = self._search.search(start, everything, budget)
                if found.exhausted:
                    return self._failed(PlanningEnd.UNREACHABLE, start)
                node = found.node or node
        end = without_needless_actions(self._successors, start, node, self._is_reached)
        return Planned(PlanningEnd.SOLVED, tuple(end.plan()), self._search.effort.used)

    def _is_reached(self, node: Node) -> bool:
        holds = self._heuristic.readings.holds
        conditions = self._goal.conditions
        return node.taken == len(self._goal.actions) and all(holds(c, {}, node.state) for c in conditions)

    def _failed(self, end: PlanningEnd, start: Node) -> Planned:
        return Planned(end, (), self._search.effort.used, self._blocked(start))

    def _blocked(self, start: Node) -> tuple[Formula | tuple[str, ...], ...]:
        estimates = Estimates(self._heuristic, start.state, self._successors.objects)
        conditions = (c for c in self._goal.conditions if estimates.to(Subgoal(c, {}, True)) == INFINITE)
        actions = (names for names in self._goal.actions if estimates.to_action(names).cost == INFINITE)
        return (*conditions, *actions)
