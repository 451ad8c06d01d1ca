"""Greedy best-first search: the state that looks nearest is expanded next.

It is expanded by its preferred operators (Hoffmann and Nebel 2001): the actions that lead towards a
condition. They are the ends of the chains that an estimate is made of (see `additive_heuristic`): those
actions on the cheapest way to the condition that are applicable at once. If those lead nowhere, every
applicable action is tried where that is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from eai.logic.formula import Atom
from eai.planning.additive_heuristic import INFINITE, AdditiveHeuristic, Estimates
from eai.planning.search import Effort, Limits, OpenList, SearchEnd, best_first
from eai.planning.subgoal import GroundAtom, Subgoal
from eai.planning.successor_generator import PlanNode, SuccessorGenerator, applicable_actions
from eai.world.action import Action
from eai.world.derived import Defined

_STEP_COST = 0.2
"""Cost of a step of the way, beside 1 for an estimated one of the way ahead: enough to leave long detours."""

_UNEXPANDED, _EXPANDED = 0, 1
"""The states not yet expanded come first."""


class GreedySearch:
    """Searches in one domain, as long as there are states left to spend.

    Args:
        heuristic: estimates with.
        successors: gives the states one action further.
        limits: how much all searches together may do.

    Attributes:
        heuristic: estimates with.
        successors: gives the states one action further.
        effort: how many states were reached and estimated.
        bindings: the number of values that were given to parameters to find actions.
    """

    def __init__(self, heuristic: AdditiveHeuristic, successors: SuccessorGenerator, limits: Limits) -> None:
        self.heuristic = heuristic
        self.successors = successors
        self.effort = Effort(limits.states)
        self.bindings = Effort(limits.bindings)
        self._looks = Effort(limits.looks)

    @property
    def is_over(self) -> bool:
        """Whether nothing more may be done."""
        return self.effort.is_used_up or self._looks.is_exceeded or self.bindings.is_exceeded

    def estimates(self, node: PlanNode, protected: Sequence[Subgoal] = ()) -> Estimates:
        """The estimates from a state; what undoes one of the kept conditions costs more."""
        return Estimates(
            self.heuristic, node.state, self.successors.objects, protected, self._looks, self.bindings
        )

    def search(
        self, start: PlanNode, subgoals: tuple[Subgoal, ...], taken: int, limits: Limits
    ) -> PlanNode | SearchEnd:
        """Look for a way from a node to its target; where there is none, say why the search ended.

        All applicable actions are tried, where the preferred ones lead nowhere, if it is to be thorough.

        Args:
            start: the node.
            subgoals: closed conditions that shall hold at the end.
            taken: how many of the action goals shall have been taken.
            limits: how much to do.
        """
        if self.is_over:
            return SearchEnd.STATES
        effort = Effort(min(limits.states, self.effort.limit - self.effort.used))
        found = _Run(self, start, (subgoals, taken), effort, thorough=limits.thorough).search()
        self.effort.used += effort.used
        return found

    def estimate(
        self, node: PlanNode, subgoals: tuple[Subgoal, ...], taken: int
    ) -> tuple[float, tuple[Action, ...]]:
        """How far a state looks from the target of `search`, and its preferred actions."""
        estimates = self.estimates(node, subgoals)
        preferred = _PreferredOperators(self.heuristic, estimates)
        total = 0.0
        for condition in subgoals:
            cost = estimates.estimate(condition)
            total += cost
            if 0.0 < cost < INFINITE:
                preferred.towards(condition)
        for names in self.successors.goals[node.met : taken]:
            supporter = estimates.estimate_action(names)
            total += supporter.cost
            preferred.along(supporter.action, supporter.before)
        return total, tuple(preferred.actions)


class _Expansion(NamedTuple):
    """A state to be expanded, where it comes, and by which actions; by all that are applicable if None."""

    node: PlanNode
    rank: tuple[float, int]
    actions: tuple[Action, ...] | None


class _Run:
    """The state of one search."""

    def __init__(
        self,
        searches: GreedySearch,
        start: PlanNode,
        target: tuple[tuple[Subgoal, ...], int],
        effort: Effort,
        *,
        thorough: bool,
    ) -> None:
        self._searches = searches
        self._successors = searches.successors
        self._start = start
        self._target = target
        self._effort = effort
        self._thorough = thorough
        self._seen = {(start.state, start.met)}
        self._open: OpenList[_Expansion] = OpenList()

    def search(self) -> PlanNode | SearchEnd:
        """Look for a way from the start to the target."""
        return self._reach(self._start) or best_first(self._open.pop, self._expand)

    def _expand(self, expansion: _Expansion) -> PlanNode | SearchEnd | None:
        """Expand a state by its preferred actions, or once more by all others when nothing else is left."""
        node, rank, actions = expansion
        if actions is not None and self._thorough:
            self._open.push(expansion._replace(actions=None), _EXPANDED, *rank)
        applicable = self._successors.applicable(node, self._searches.bindings)
        for action in applicable if actions is None else actions:
            if self._is_over:
                break
            after = self._successors.successor(node, action)
            if after is None or (after.state, after.met) in self._seen:
                continue
            self._seen.add((after.state, after.met))
            found = self._reach(after)
            if found is not None:
                return found
        return SearchEnd.STATES if self._is_over else None

    @property
    def _is_over(self) -> bool:
        return self._effort.is_used_up or self._searches.is_over

    def _reach(self, node: PlanNode) -> PlanNode | None:
        """Estimate a state that was reached and queue it; the node itself if the target is reached in it."""
        self._effort.used += 1
        ahead, preferred = self._searches.estimate(node, *self._target)
        if ahead == 0.0:
            return node
        cost = ahead + _STEP_COST * (node.depth - self._start.depth)
        rank = (cost, -self._effort.used)
        self._open.push(_Expansion(node, rank, preferred), _UNEXPANDED, *rank)
        return None


class _PreferredOperators:
    """Collects the preferred actions of one state.

    Args:
        heuristic: the heuristic for the domain.
        estimates: the estimates from the state.

    Attributes:
        actions: those found, each once, in order.
    """

    def __init__(self, heuristic: AdditiveHeuristic, estimates: Estimates) -> None:
        self._heuristic = heuristic
        self._estimates = estimates
        self._seen: set[GroundAtom] = set()
        self.actions: dict[Action, None] = {}

    def towards(self, goal: Subgoal) -> None:
        """Collect those on the cheapest way to a goal, or on all the cheapest where it has alternatives."""
        alternatives = self._estimates.find_alternatives(goal)
        for condition in alternatives:
            self.towards(condition)
        if not alternatives:
            self._collect(goal)

    def along(self, action: Action | None, before: Sequence[Subgoal]) -> None:
        """Collect an action, if it is applicable at once, or those that lead to what it needs first."""
        if action is not None and not before:
            self.actions[action] = None
        for condition in before:
            self._collect(condition)

    def _collect(self, subgoal: Subgoal) -> None:
        """Collect those on the cheapest way to a condition, of which there is one."""
        if self._estimates.holds(subgoal):
            return
        if isinstance(subgoal.formula, Atom):
            atom = self._estimates.atom(subgoal.formula, subgoal)
            if atom in self._seen:
                return
            self._seen.add(atom)
            derived = self._heuristic.derived.get(atom.predicate)
            if derived is None:
                supporter = self._estimates.find_supporter(atom)
                self.along(supporter.action, supporter.before)
                return
            if not isinstance(derived, Defined):
                self.actions.update((action, None) for action in self._changing(derived.reads))
        for part in self._estimates.choose_parts(subgoal) or ():
            self._collect(part)

    def _changing(self, predicates: tuple[str, ...]) -> Iterator[Action]:
        """All actions applicable at once that change some of these predicates."""
        for operator in self._heuristic.achievers.writers(predicates):
            yield from applicable_actions(
                self._heuristic.domain,
                operator,
                self._estimates.state,
                self._estimates.objects,
                self._estimates.bindings,
            )
