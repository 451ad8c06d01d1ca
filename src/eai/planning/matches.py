"""Matches: what the achievers of an atom can be about, as far as no action changes that.

They are the same in all states that differ in nothing but what actions change, so that a search finds each
of them once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

from eai.planning.achievers import Achiever, Achievers, Partial, completed
from eai.planning.subgoal import GroundAtom
from eai.world.frame import Binding
from eai.world.state import State

_KEPT = 64
"""How many bindings of one achiever are kept at most: where there are more, they are found again."""


class Match(NamedTuple):
    """An achiever of an atom.

    Attributes:
        achiever: the achiever.
        partial: the objects of those of its variables that the atom determines.
        kept: all ways to complete that, as bindings; None if they are to be found in every state.
    """

    achiever: Achiever
    partial: Partial
    kept: Sequence[tuple[int, ...]] | None

    def bindings(self, state: State, usable: int) -> Iterator[Binding]:
        """The ways to complete it, as `Achiever.bindings` yields them."""
        return completed(state, self.partial, usable) if self.kept is None else map(list, self.kept)


class Matches:
    """The matches in states with the same fixed facts.

    Args:
        achievers: of the domain.
        state: one of the states.
        usable: the mask of the objects that actions may be about.
    """

    def __init__(self, achievers: Achievers, state: State, usable: int) -> None:
        self._achievers = achievers
        self._state = state
        self._usable = usable
        self._fixed = achievers.fixed_facts(state)
        self._found: dict[GroundAtom, Sequence[Match]] = {}

    def are_of(self, state: State, usable: int) -> bool:
        """Whether they are those in a state."""
        return (
            self._state.scene is state.scene
            and self._usable == usable
            and self._fixed == self._achievers.fixed_facts(state)
        )

    def of(self, atom: GroundAtom) -> Sequence[Match]:
        """The matches of an atom of a stored predicate, in the order of its achievers."""
        found = self._found.get(atom)
        if found is None:
            found = self._found[atom] = self._find(atom)
        return found

    def _find(self, atom: GroundAtom) -> Sequence[Match]:
        found: list[Match] = []
        for achiever in self._achievers.of(atom.predicate, adding=atom.truth):
            scope = achiever.match(atom.arguments, self._state.scene.agent)
            if scope is not None:
                fixed = achiever.partial(self._state.scene, scope, fixed=True)
                most = _KEPT + 1 if achiever.is_fixed else 1
                bindings = [tuple(b) for b in islice(completed(self._state, fixed, self._usable), most)]
                if bindings:
                    partial = achiever.partial(self._state.scene, scope)
                    found.append(Match(achiever, partial, bindings if len(bindings) < most else None))
        return found
