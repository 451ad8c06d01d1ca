"""The facts of a state by the names of objects."""

from __future__ import annotations

from eai.world.relation import bits
from eai.world.state import State
from eai.world.vocabulary import Predicate


class Facts:
    """Reads the stored predicates of a state.

    Args:
        state: the state.
    """

    def __init__(self, state: State) -> None:
        self._state = state
        self._index = state.scene.index
        self._names = [thing.name for thing in state.scene.objects]

    def _has(self, predicate: Predicate, *names: str) -> bool:
        return self._state.has(predicate.name, *[self._index[name] for name in names])

    def _those(self, predicate: Predicate) -> list[str]:
        """The things of which a predicate holds."""
        return [self._names[i] for i in bits(self._state.those(predicate.name))]

    def _of(self, predicate: Predicate, name: str) -> list[str]:
        """The things to which a thing stands in a relation."""
        return [self._names[i] for i in bits(self._state.relation(predicate.name).row(self._index[name]))]

    def _to(self, predicate: Predicate, name: str) -> list[str]:
        """The things that stand in a relation to a thing."""
        return [self._names[i] for i in bits(self._state.relation(predicate.name).column(self._index[name]))]
