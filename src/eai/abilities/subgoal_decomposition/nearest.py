"""What a search in vain tells: the plan that comes nearest to its aim, and the action that fails."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.ground import Ground
from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.subgoal_decomposition.refining import Node, Refining
from eai.world.execution import Action
from eai.world.state import State


class _Nearest(NamedTuple):
    """A plan that comes near an aim, and how many checks its last action fails."""

    failing: int
    plan: Plan


class _Attempt(NamedTuple):
    """An action that fails: where, after what, and the numbers of the checks that do."""

    node: Node
    ground: Ground
    plan: tuple[Action, ...]
    state: State
    failing: list[int]


def nearest_of(in_vain: Sequence[Refining]) -> Plan:
    """Of some searches in vain the plan that meets most parts; of several the first that fails least."""
    most = max([refining.most_met for refining in in_vain])
    best: _Nearest | None = None
    for refining in in_vain:
        if refining.most_met == most and (best is None or best.failing):
            nearest = _Failing(refining).nearest()
            best = nearest if best is None or nearest.failing < best.failing else best
    return () if best is None else best.plan


class _Failing:
    """A search that found nothing."""

    def __init__(self, refining: Refining) -> None:
        self._aim = refining.aim
        self._means = refining.means
        self._movement = refining.movement
        self._out_of_reach = refining.out_of_reach
        most = refining.most_met
        self._nodes = [node for node in refining.nodes if node.met.bit_count() == most]

    def nearest(self) -> _Nearest:
        """What comes nearest to the aim, and the action that fails there.

        That is the one which lacks least of those that would help, or another one that would mend what it
        lacks. No action fails where each part can be reached, but not together with the others.
        """
        first = self._nodes[0]
        best: _Attempt | None = None
        for node in self._nodes:
            for ground in (*self._means.wanted, *self._means.moving):
                missing = ground.parts & ~node.met
                if not missing or not self._may_lack_less(node, ground, best):
                    continue
                if self._aim.met(ground.after(node.state), ground.touched & missing, 0):
                    attempt = self._attempt(node, ground, best)
                    if not attempt.failing:
                        return _Nearest(0, first.plan)
                    if best is None or len(attempt.failing) < len(best.failing):
                        best = attempt
        if best is not None:
            return _Nearest(len(best.failing), (self._cause(best) or best).plan)
        for ground in self._means.wanted:  # what would help needs something else first, or tries in vain
            attempt = self._attempt(first, ground)
            vain = attempt if attempt.failing == [len(ground.known.operator.checks)] else None
            cause = self._cause(attempt) or vain
            if cause is not None:
                return _Nearest(len(cause.failing), cause.plan)
        return _Nearest(0, first.plan)

    def _may_lack_less(self, node: Node, ground: Ground, other: _Attempt | None) -> bool:
        """Whether fewer checks may fail of an action, be it after movement, than in another attempt."""
        if other is None:
            return True
        fewest = self._fewest(node, ground, ground.lacking(node.state, len(other.failing)))
        return fewest < len(other.failing)

    def _fewest(self, node: Node, ground: Ground, lacking: int) -> int:
        """How many checks of an action fail at least, of which so many do: one, where it is out of reach."""
        return lacking or int((node.state, ground.action) in self._out_of_reach)

    def _attempt(self, node: Node, ground: Ground, other: _Attempt | None = None) -> _Attempt:
        """An action tried where, of all states that movement leads to, the fewest of its checks fail.

        Movement is not looked at where it cannot make fewer fail than in the ``other`` attempt.
        """
        failing = ground.failing(node.state)
        best = _Attempt(node, ground, (*node.plan, ground.action), node.state, failing)
        least = self._fewest(node, ground, sum([not ground.known.moved[i] for i in failing]))
        if other is not None and least >= len(other.failing):
            return best
        if len(failing) > least:
            for way in self._movement.ways(node.state):
                failing = ground.failing(way.state)
                if len(failing) < len(best.failing):
                    plan = (*node.plan, *way.plan, ground.action)
                    best = _Attempt(node, ground, plan, way.state, failing)
                    if len(failing) == least:
                        break
        return best

    def _cause(self, attempt: _Attempt) -> _Attempt | None:
        """The attempt at another action that would make a failing check hold, where all of those fail."""
        if attempt.ground.is_hopeless(attempt.failing):
            return None
        lacking = len(attempt.failing)
        mending = [
            self._attempt(attempt.node, ground)
            for ground in self._means.helping
            if len(attempt.ground.failing(ground.after(attempt.state))) < lacking
        ]
        return mending[0] if mending and all(other.failing for other in mending) else None
