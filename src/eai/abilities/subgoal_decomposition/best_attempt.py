"""The best failed attempt: the plan nearest to a subgoal that none reaches, and the action that fails."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.ground import Ground
from eai.abilities.subgoal_decomposition.program import MAX_ACTIONS, TOO_FAR, Found
from eai.abilities.subgoal_decomposition.uniform_cost import UniformCostSearch
from eai.planning.successor_generator import PlanNode
from eai.world.execution import Action
from eai.world.state import State

_LOOKED_AT = 16
"""How many states are looked at for what fails there: where it begins, where most parts are met, others."""

_MOST_TESTS = 200_000
"""How many parts may be tested there; of a goal with very many fewer states are looked at."""


class _Rank(NamedTuple):
    """How near an attempt comes: the least would meet most parts, lacks least for that, and is the shortest.

    Attributes:
        met: how many parts would be met, negative.
        failing: how many checks fail.
        length: how many actions there are.
    """

    met: int
    failing: int
    length: int


class _Attempt(NamedTuple):
    """An action that is tried: where, after what, and the numbers of the checks that fail."""

    node: PlanNode
    ground: Ground
    plan: tuple[Action, ...]
    state: State
    failing: list[int]


class _Nearest(NamedTuple):
    """How near an attempt comes, and the one to report; None where a plan would be too long."""

    rank: _Rank
    reported: _Attempt | None


def best_failed_attempt(searches: Sequence[UniformCostSearch]) -> Found:
    """The plan that comes nearest to the goal of searches that found none, and the action that fails there.

    That is the most direct of those that lack least for what would meet most parts, or another action that
    would mend what it lacks; none if nothing fails, but it takes too long. Where each part can be reached,
    but not together with the others, the plan is the shortest that meets most parts.
    """
    failing = [_Failed(search) for search in searches]
    most_met = max([each.most_met for each in failing])
    farthest = [each for each in failing if each.most_met == most_met]
    found = [nearest for each in farthest if (nearest := each.nearest()) is not None]
    effort = sum([each.effort for each in failing])
    if found:
        reported = min(found, key=lambda nearest: nearest.rank).reported
        if reported is None:
            return Found((), effort, TOO_FAR, has_failed=True)
        return Found((reported.plan,), effort, has_failed=not reported.ground.is_hopeless(reported.failing))
    nodes = [node for search in searches for node in search.nodes]
    most = max(nodes, key=lambda node: (node.met.bit_count(), -node.depth))
    return Found((most.plan(),), effort, has_failed=True)


class _Failed:
    """A search that found nothing.

    Args:
        search: the search.

    Attributes:
        effort: how many actions have been applied to states, or looked at after movement.
        most_met: how many parts are met in one of its states, at the most.
    """

    def __init__(self, search: UniformCostSearch) -> None:
        self._goal = search.goal
        self._permitted = search.permitted
        self._movement = search.movement
        self._out_of_reach = search.out_of_reach
        self.effort = 0
        start, *others = search.nodes
        self.most_met = max([node.met.bit_count() for node in search.nodes])
        others.sort(key=lambda node: -node.met.bit_count())
        tests = self._goal.size * (len(self._permitted.achievers) + len(self._permitted.moving))
        self._nodes = [start, *others][: max(1, min(_LOOKED_AT, _MOST_TESTS // max(1, tests)))]

    def nearest(self) -> _Nearest | None:
        """The attempt that comes nearest to the goal; None if none brings more of it about than was made.

        What fails and would bring about no more than was made otherwise is not reported.
        """
        best: _Attempt | None = None
        rank = _Rank(0, 0, 0)
        for node in self._nodes:
            for ground in (*self._permitted.achievers, *self._permitted.moving):
                met = -self._met_after(node, ground)
                if not met or (best is not None and self._least(node, ground, met) >= rank):
                    continue
                attempt = self._attempt(node, ground)
                if attempt.failing and -met <= self.most_met:
                    continue
                found = _Rank(met, len(attempt.failing), len(attempt.plan))
                made = not attempt.failing and len(attempt.plan) <= MAX_ACTIONS
                if not made and (best is None or found < rank):
                    best, rank = attempt, found
        if best is not None:
            return _Nearest(rank, self._reported(best))
        first = self._nodes[0]
        for ground in (
            self._permitted.achievers
        ):  # what would help needs something else first, or fails at what it tries
            attempt = self._attempt(first, ground)
            reported = self._reported(attempt)
            vain = attempt.failing == [len(ground.known.operator.checks)]
            if attempt.failing and (vain or reported is not attempt):
                return _Nearest(_Rank(0, len(attempt.failing), len(attempt.plan)), reported)
        return None

    def _met_after(self, node: PlanNode, ground: Ground) -> int:
        """How many parts are met after an action that is for one; 0 if there are no more than before."""
        missing = ground.parts & ~node.met
        if not missing:
            return 0
        self.effort += self._goal.step_effort
        after = ground.after(node.state)
        if not self._goal.met(after, ground.touched & missing, 0):
            return 0
        met = self._goal.met(after, ground.touched, node.met).bit_count()
        return met if met > node.met.bit_count() else 0

    def _least(self, node: PlanNode, ground: Ground, met: int) -> _Rank:
        """The least rank that an action may have, be it after movement."""
        lacking = ground.lacking(node.state, len(ground.known.moved))
        return _Rank(met, self._fewest(node, ground, lacking), node.depth + 1)

    def _fewest(self, node: PlanNode, ground: Ground, lacking: int) -> int:
        """How many checks of an action fail at least, of which so many do: one, where it is out of reach."""
        return lacking or int((node.state, ground.action) in self._out_of_reach)

    def _attempt(self, node: PlanNode, ground: Ground) -> _Attempt:
        """An action tried where, of all states that movement leads to, the fewest of its checks fail."""
        self.effort += 1
        failing = ground.failing(node.state)
        best = _Attempt(node, ground, (*node.plan(), ground.action), node.state, failing)
        least = self._fewest(node, ground, sum([not ground.known.moved[i] for i in failing]))
        if len(failing) > least:
            for way in self._movement.ways(node.state):
                self.effort += 1
                failing = ground.failing(way.state)
                if len(failing) < len(best.failing):
                    plan = (*node.plan(), *way.plan(), ground.action)
                    best = _Attempt(node, ground, plan, way.state, failing)
                    if len(failing) == least:
                        break
        return best

    def _reported(self, attempt: _Attempt) -> _Attempt | None:
        """The attempt, or one at another action that would mend what fails, where all such actions fail.

        None where it does not fail but is too long, or such an action is possible and undoes nothing.
        """
        node, ground, _, state, failing = attempt
        if not failing:
            return None
        if ground.is_hopeless(failing):
            return attempt
        mending = [
            self._attempt(node, other)
            for other in self._permitted.helping
            if len(ground.failing(other.after(state))) < len(failing)
        ]
        if any(not each.failing and self._undoes_nothing(each) for each in mending):
            return None
        return mending[0] if mending and all(each.failing for each in mending) else attempt

    def _undoes_nothing(self, attempt: _Attempt) -> bool:
        node, ground = attempt.node, attempt.ground
        return self._goal.met(ground.after(attempt.state), ground.touched, node.met) == node.met
