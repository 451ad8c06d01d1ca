"""Traces: the states and actions on which formulas are evaluated. A state gives the truth of atoms.

Sets of positions are bit masks: bit i stands for position i.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol, TypeAlias

from eai.base.errors import InputError


class _TraceState(Protocol):
    """A state of a trace: it gives the truth of atoms. Objects have the names that formulas use."""

    def holds(self, predicate: str, arguments: tuple[str, ...]) -> bool:
        """Whether the atom is true. An atom with an unknown predicate or object is false."""
        ...

    def list_objects(self, category: str | None) -> Sequence[str]:
        """Return the objects of a category, each once, in a fixed order.

        The category None means all objects.
        """
        ...


PositionMask: TypeAlias = int
"""Set of positions of a trace, as a bit mask."""

TakenAction: TypeAlias = tuple[str, tuple[str, ...]]
"""An action that was taken, with its objects."""


class Trace:
    """A finite, nonempty sequence of states with the actions between them.

    Action i is taken in state i and leads to state i + 1. So a formula about action i is true at position i,
    and no action is taken at the last position. All states have the same objects. Truth values are computed
    on demand and cached.

    Args:
        states: the states, at least one.
        actions: one action fewer than states; or no actions, if formulas mention none.

    Raises:
        InputError: the number of actions does not fit the number of states.
    """

    def __init__(self, states: Sequence[_TraceState], actions: Sequence[TakenAction] = ()) -> None:
        if not states or (actions and len(actions) != len(states) - 1):
            raise InputError(
                f"{len(states)} states and {len(actions)} actions: expected at least one state, and one "
                "action fewer than states or no actions"
            )
        self._states = states
        self._latest_first = [state.holds for state in reversed(states)]
        self.length = len(states)
        self._atoms: dict[tuple[str, tuple[str, ...]], int] = {}
        self._domains: dict[str | None, frozenset[str]] = {}
        self._actions: dict[str, dict[tuple[str, ...], int]] = {}
        for position, (name, arguments) in enumerate(actions):
            occurrences = self._actions.setdefault(name, {})
            occurrences[arguments] = occurrences.get(arguments, 0) | 1 << position

    def find_positions_of_atom(self, predicate: str, arguments: tuple[str, ...]) -> PositionMask:
        """Return the mask of the positions at which an atom holds."""
        key = (predicate, arguments)
        mask = self._atoms.get(key)
        if mask is None:
            digits = ["1" if holds(predicate, arguments) else "0" for holds in self._latest_first]
            mask = self._atoms[key] = int("".join(digits), 2)
        return mask

    def find_positions_of_action(self, action: str, arguments: tuple[str, ...]) -> PositionMask:
        """Return the positions at which the trace takes an action with these objects, as a bit mask."""
        return self._actions.get(action, {}).get(arguments, 0)

    def find_values_of_argument(self, action: str, argument_index: int) -> frozenset[str]:
        """Return the objects that occur as argument ``argument_index`` (from 0) of an action on the trace."""
        occurrences = self._actions.get(action, {})
        return frozenset(
            arguments[argument_index] for arguments in occurrences if argument_index < len(arguments)
        )

    def list_objects(self, category: str | None) -> Sequence[str]:
        """Return the objects of a category, in the order of the trace's first state."""
        return self._states[0].list_objects(category)

    def get_object_set(self, category: str | None) -> frozenset[str]:
        """Return the set of objects of a category."""
        if category not in self._domains:
            self._domains[category] = frozenset(self.list_objects(category))
        return self._domains[category]


def iterate_positions(mask: PositionMask) -> Iterator[int]:
    """Yield the positions in a bit mask, ascending."""
    while mask:
        lowest = mask & -mask
        yield lowest.bit_length() - 1
        mask ^= lowest
