"""Which actions lead towards a condition (Hoffmann and Nebel 2001).

They are the ends of the chains that an estimate is made of (see `regression`): those actions on the cheapest
way to the condition that are possible at once.
"""

from __future__ import annotations

from collections.abc import Iterator

from eai.logic.formula import Atom
from eai.planning.additive_heuristic import Distances, Regression, Way
from eai.planning.successor_generator import possible_actions
from eai.planning.wanted import GroundAtom, Wanted
from eai.world.execution import Action
from eai.world.vocabulary import Defined


class Helpful:
    """Collects the helpful actions of one state.

    Args:
        regression: the domain.
        distances: the estimates from the state.

    Attributes:
        actions: those found, each once, in order.
    """

    def __init__(self, regression: Regression, distances: Distances) -> None:
        self._domain = regression
        self._distances = distances
        self._seen: set[GroundAtom] = set()
        self.actions: dict[Action, None] = {}

    def towards(self, goal: Wanted) -> None:
        """Collect those on the cheapest way to a goal, or on all the cheapest where it has alternatives."""
        alternatives = self._distances.alternatives(goal)
        for condition in alternatives:
            self.towards(condition)
        if not alternatives:
            self._collect(goal)

    def along(self, way: Way) -> None:
        """Collect those on a way."""
        if way.action is not None and not way.before:
            self.actions[way.action] = None
        for condition in way.before:
            self._collect(condition)

    def _collect(self, wanted: Wanted) -> None:
        """Collect those on the cheapest way to a condition, of which there is one."""
        if self._distances.holds(wanted):
            return
        if isinstance(wanted.formula, Atom):
            atom = self._distances.atom(wanted.formula, wanted)
            if atom in self._seen:
                return
            self._seen.add(atom)
            derived = self._domain.derived.get(atom.predicate)
            if derived is None:
                self.along(self._distances.way(atom))
                return
            if not isinstance(derived, Defined):
                self.actions.update((action, None) for action in self._changing(derived.reads))
        for part in self._distances.needed(wanted) or ():
            self._collect(part)

    def _changing(self, predicates: tuple[str, ...]) -> Iterator[Action]:
        """All actions possible at once that change some of these predicates."""
        for operator in self._domain.achievers.writers(predicates):
            yield from possible_actions(
                self._domain.domain, operator, self._distances.state, self._distances.objects
            )
