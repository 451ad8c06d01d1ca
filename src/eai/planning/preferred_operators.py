"""Preferred operators: the actions that lead towards a condition (Hoffmann and Nebel 2001).

They are the ends of the chains that an estimate is made of (see `additive_heuristic`): those actions on the
cheapest way to the condition that are applicable at once.
"""

from __future__ import annotations

from collections.abc import Iterator

from eai.logic.formula import Atom
from eai.planning.additive_heuristic import AdditiveHeuristic, Estimates, Supporter
from eai.planning.subgoal import GroundAtom, Subgoal
from eai.planning.successor_generator import applicable_actions
from eai.world.derived import Defined
from eai.world.execution import Action


class PreferredOperators:
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
        alternatives = self._estimates.alternatives(goal)
        for condition in alternatives:
            self.towards(condition)
        if not alternatives:
            self._collect(goal)

    def along(self, supporter: Supporter) -> None:
        """Collect an action, if it is applicable at once, or those that lead to what it needs first."""
        if supporter.action is not None and not supporter.before:
            self.actions[supporter.action] = None
        for condition in supporter.before:
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
                self.along(self._estimates.supporter(atom))
                return
            if not isinstance(derived, Defined):
                self.actions.update((action, None) for action in self._changing(derived.reads))
        for part in self._estimates.needed(subgoal) or ():
            self._collect(part)

    def _changing(self, predicates: tuple[str, ...]) -> Iterator[Action]:
        """All actions applicable at once that change some of these predicates."""
        for operator in self._heuristic.achievers.writers(predicates):
            yield from applicable_actions(
                self._heuristic.domain, operator, self._estimates.state, self._estimates.objects
            )
