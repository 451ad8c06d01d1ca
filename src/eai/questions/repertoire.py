"""All that a few ground actions can lead to: exhausted, so that what is out of reach is proved to be."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from eai.world.execution import Action
from eai.world.state import Fact, State


class World(Protocol):
    """What actions do, as far as it can be told."""

    def after(self, state: State, action: Action) -> State | None:
        """The state after an action; None where it is impossible."""

    def added(self, before: State, after: State) -> Sequence[Fact]:
        """What holds in one state and not in another."""


@dataclass(frozen=True, slots=True)
class Edge:
    """An action and the state that it leads to, by their numbers."""

    action: int
    target: int


@dataclass(frozen=True)
class Repertoire:
    """Some actions, each of which may be taken as often as one likes, and everything they lead to.

    Attributes:
        actions: the actions.
        states: every state that can be reached, the start first, nearer ones before farther ones.
        edges: of every state what each action that is possible in it leads to.
        depths: of every state how many actions it takes to get there.
        gained: of every state what holds in it and not at the start.
    """

    actions: tuple[Action, ...]
    states: tuple[State, ...]
    edges: tuple[tuple[Edge, ...], ...]
    depths: tuple[int, ...]
    gained: tuple[tuple[Fact, ...], ...]

    @property
    def becoming_true(self) -> frozenset[Fact]:
        """All facts that do not hold at the start and do at some time."""
        return frozenset().union(*self.gained)

    def within(self, actions: Sequence[int]) -> Repertoire:
        """What some of the actions, by their numbers, lead to."""
        place = {number: n for n, number in enumerate(actions)}
        numbers, depths, edges = {0: 0}, [0], list[tuple[Edge, ...]]()
        for n, old in enumerate(kept := [0]):  # which grows on the way
            found = []
            for edge in self.edges[old]:
                if edge.action in place:
                    if edge.target not in numbers:
                        numbers[edge.target] = len(kept)
                        kept.append(edge.target)
                        depths.append(depths[n] + 1)
                    found.append(Edge(place[edge.action], numbers[edge.target]))
            edges.append(tuple(found))
        return Repertoire(
            tuple([self.actions[number] for number in actions]),
            tuple([self.states[n] for n in kept]),
            tuple(edges),
            tuple(depths),
            tuple([self.gained[n] for n in kept]),
        )

    def distance(self, is_goal: Callable[[int], bool], *, without: int | None = None) -> int | None:
        """How many actions lead from the start to a goal at least; None if none do.

        Args:
            is_goal: whether a state, by its number, is one.
            without: an action, by its number, that is not taken.
        """
        if without is None:
            return next((depth for n, depth in enumerate(self.depths) if is_goal(n)), None)
        level, seen, depth = [0], {0}, 0
        while level:
            if any(is_goal(n) for n in level):
                return depth
            further = [e.target for n in level for e in self.edges[n] if e.action != without]
            level = [n for n in dict.fromkeys(further) if n not in seen]
            seen.update(level)
            depth += 1
        return None

    def from_here(self, is_goal: Callable[[int], bool]) -> Mapping[int, int]:
        """How many actions lead from each state to a goal at least; of those from which none do, nothing."""
        sources: list[list[int]] = [[] for _ in self.states]
        for n, edges in enumerate(self.edges):
            for edge in edges:
                sources[edge.target].append(n)
        level = [n for n in range(len(self.states)) if is_goal(n)]
        found = dict.fromkeys(level, 0)
        depth = 0
        while level:
            depth += 1
            level = [n for n in dict.fromkeys([s for t in level for s in sources[t]]) if n not in found]
            found.update(dict.fromkeys(level, depth))
        return found


def exhaust(world: World, start: State, actions: Sequence[Action], most: int) -> Repertoire | None:
    """All that some actions lead to from a state; None if that is more states than ``most``."""
    numbers, states, depths = {start: 0}, [start], [0]
    edges: list[tuple[Edge, ...]] = []
    for n, state in enumerate(states):  # which grows on the way
        found = []
        for number, action in enumerate(actions):
            after = world.after(state, action)
            if after is None:
                continue
            target = numbers.setdefault(after, len(states))
            if target == len(states):
                if target == most:
                    return None
                states.append(after)
                depths.append(depths[n] + 1)
            found.append(Edge(number, target))
        edges.append(tuple(found))
    gained = [tuple(world.added(start, state)) for state in states]
    return Repertoire(tuple(actions), tuple(states), tuple(edges), tuple(depths), tuple(gained))
