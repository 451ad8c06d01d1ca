"""One search for the actions that carry out a subgoal from a state: for what, `refinement` says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.ground import Ground, told_apart
from eai.abilities.subgoal_decomposition.movement import Movement, Way
from eai.abilities.subgoal_decomposition.program import MAX_ACTIONS, Plan
from eai.abilities.subgoal_decomposition.repertoire import Holds
from eai.planning.search import Effort
from eai.world.execution import Action
from eai.world.state import State

MAX_PLANS = 4
"""The most sequences that are found for one subgoal."""

_TESTED_AT_ONCE = 16
"""How many parts are tested in the time in which an action is applied."""


class Means(NamedTuple):
    """What may be done.

    Attributes:
        wanted: what may bring the subgoal about.
        helping: what may make that possible.
        moving: movement that may bring the subgoal about.
        movement: what moves the agent.
        touched: the mask of the parts that movement can change.
    """

    wanted: Sequence[Ground]
    helping: Sequence[Ground]
    moving: Sequence[Ground]
    movement: Sequence[Ground]
    touched: int


class Aim(NamedTuple):
    """What the search is for.

    Attributes:
        at_start: the mask of its parts that hold where the search begins.
        met: the mask of those that hold in a state: of the parts in a mask they are looked at, of the others
            it is those of another mask.
        everything: the mask of all parts.
        holds: whether what it asks for besides its parts holds in a state.
        told_apart: the operators of which it matters that they are taken, whatever state they lead to.
        effort: how many applied actions a test of `holds` stands for.
    """

    at_start: int
    met: Callable[[State, int, int], int]
    everything: int
    holds: Holds
    told_apart: Collection[str]
    effort: int = 0

    @property
    def size(self) -> int:
        """How many parts it has."""
        return self.everything.bit_count()

    @property
    def step_effort(self) -> int:
        """How many applied actions one stands for after which all parts are tested."""
        return 1 + self.size // _TESTED_AT_ONCE


class Node(NamedTuple):
    """A state that was reached, the mask of the parts met there, and the way."""

    state: State
    met: int
    plan: tuple[Action, ...]


class Refining:
    """A search by the length of plans, of which none has more than `MAX_ACTIONS`.

    Args:
        aim: what it is for.
        means: what may be done.
        budget: how many actions may be applied to states.

    Attributes:
        aim: what it is for.
        means: what may be done.
        movement: where movement leads.
        nodes: the states that were reached without what is searched for, the nearest first.
        out_of_reach: what movement does not make possible, and where.
    """

    def __init__(self, aim: Aim, means: Means, budget: int) -> None:
        self.aim = aim
        self.means = means
        self._effort = Effort(budget)
        self.movement = Movement(means.movement, self._effort)
        self._best = MAX_ACTIONS
        self.nodes: list[Node] = []
        self.out_of_reach: set[tuple[State, Action]] = set()

    @property
    def effort(self) -> int:
        """How many actions have been applied to states."""
        return self._effort.used

    def shortest(self, start: State) -> list[Plan]:
        """The shortest plans, at most `MAX_PLANS`; no two to one state that the goal cannot tell apart."""
        grounds = [g for g in (*self.means.wanted, *self.means.helping) if g.is_ever_possible(start)]
        found: dict[object, Plan] = {}
        queue = [(0, 0, Node(start, self.aim.at_start, ()))]
        lengths = {start: 0}
        numbers = count(1)
        while queue and not self._effort.is_used_up:
            length, _, node = heappop(queue)
            self.nodes.append(node)
            if length >= self._best:
                continue
            for child in self._children(node, grounds):
                length = len(child.plan)
                if child.met == self.aim.everything and self._holds(child.state):
                    found = found if length == self._best else {}
                    self._best = length
                    found.setdefault((child.state, told_apart(child.plan, self.aim.told_apart)), child.plan)
                    if len(found) == MAX_PLANS:
                        return list(found.values())
                elif length < lengths.get(child.state, length + 1):
                    lengths[child.state] = length
                    heappush(queue, (length, next(numbers), child))
        return list(found.values())

    def _holds(self, state: State) -> bool:
        """Whether all that is asked for holds; a long formula costs as much as it is long."""
        self._effort.used += self.aim.effort
        return self.aim.holds(state)

    def _children(self, node: Node, grounds: Sequence[Ground]) -> Iterator[Node]:
        """What comes after a node, in plans no longer than the best."""
        allowed: dict[str, bool] = {}
        for ground in grounds:
            is_deed, parts = ground.is_deed, ground.parts & ~node.met
            if is_deed and not parts:
                continue
            name = ground.action.operator
            if name not in allowed:
                allowed[name] = ground.known.common(node.state, ground.binding)
            way = self._approach(node, ground) if allowed[name] else None
            if way is None:
                continue
            self._effort.used += 1
            after = ground.after(way.state)
            touched = ground.touched | (self.means.touched if way.plan else 0)
            gained = self.aim.met(after, parts, 0) if is_deed else 0
            if is_deed and not gained:
                continue
            met = gained | self.aim.met(after, touched & ~parts if is_deed else touched, node.met)
            yield Node(after, met, (*node.plan, *way.plan, ground.action))
        if self.means.moving:
            for way in self.movement.ways(node.state):
                if self._is_too_long(len(node.plan) + len(way.plan)):
                    break
                met = self.aim.met(way.state, self.means.touched, node.met)
                if met & ~node.met:
                    yield Node(way.state, met, (*node.plan, *way.plan))

    def _is_too_long(self, length: int) -> bool:
        return length > self._best

    def _approach(self, node: Node, ground: Ground) -> Way | None:
        """The shortest movement that makes an action possible; None if none does, or it takes too long."""
        state, before = node.state, len(node.plan) + 1
        if self._is_too_long(before):
            return None
        if ground.is_possible_now(state):
            return Way((), state)
        if not self.movement or not ground.may_be_mended(state):
            return None
        for way in self.movement.ways(state):
            if self._is_too_long(before + len(way.plan)):
                return None
            if ground.is_possible_now(way.state):
                return way
        self.out_of_reach.add((state, ground.action))
        return None
