"""Where movement leads: what makes another action possible, and is done as often as that needs it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.ground import Ground
from eai.planning.search import Effort
from eai.world.execution import Action
from eai.world.state import State

_MOST_MOVES = 3
"""Movements before one action: to stand up, to go there and to turn to it."""


class Way(NamedTuple):
    """Actions, and the state after them."""

    plan: tuple[Action, ...]
    state: State


class Movement:
    """What movement leads to.

    Args:
        moves: what moves the agent.
        effort: how many actions may be applied to states.
    """

    def __init__(self, moves: Sequence[Ground], effort: Effort) -> None:
        self._moves = moves
        self._effort = effort
        self._ways: dict[State, _Ways] = {}

    def __bool__(self) -> bool:
        return bool(self._moves)

    def ways(self, state: State) -> Iterable[Way]:
        """All that movement leads to, the shortest ways first; found as far as it is looked at."""
        ways = self._ways.get(state)
        if ways is None:
            ways = self._ways[state] = _Ways(self._from(state))
        return ways

    def _from(self, start: State) -> Iterator[Way]:
        moves = [ground for ground in self._moves if ground.is_ever_possible(start)]
        seen = {start}
        ways = [Way((), start)]
        for _ in range(_MOST_MOVES):
            farther: list[Way] = []
            for way in ways:
                taken = [action.operator for action in way.plan]
                for ground in moves:
                    if ground.action.operator in taken or self._effort.is_used_up:
                        continue
                    if ground.known.common(way.state, ground.binding) and ground.is_possible_now(way.state):
                        self._effort.used += 1
                        after = ground.after(way.state)
                        if after not in seen:
                            seen.add(after)
                            farther.append(Way((*way.plan, ground.action), after))
                            yield farther[-1]
            ways = farther


class _Ways:
    """Ways as they are found, to be looked at again and again."""

    def __init__(self, ways: Iterator[Way]) -> None:
        self._ways = ways
        self._found: list[Way] = []

    def __iter__(self) -> Iterator[Way]:
        yield from self._found
        for way in self._ways:
            self._found.append(way)
            yield way
