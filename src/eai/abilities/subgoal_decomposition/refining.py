"""One search for the actions that carry out a subgoal from a state: for what, `refinement` says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush
from itertools import count, product
from typing import NamedTuple, TypeAlias

from eai.abilities.subgoal_decomposition.program import Plan
from eai.world.domain import CompiledOperator
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.state import State

Holds: TypeAlias = Callable[[State], bool]
"""Whether something holds in a state."""

MAX_PLANS = 4
"""The most sequences that are found for one subgoal."""

_MOST_MOVES = 3
"""Movements before one action: to stand up, to go there and to turn to it."""

_A_PART = 4
"""Actions that a part takes: to go to a thing, take it, go elsewhere and put it there."""


class Ground(NamedTuple):
    """An action that may be taken.

    Attributes:
        action: the action.
        operator: its operator.
        is_deed: whether it counts as a deed.
        mended: for each check of the operator, whether movement can make it hold; then False, for what it
            tries.
        parts: the mask of the parts of the aim that it is for; 0 if it helps another one.
    """

    action: Action
    operator: CompiledOperator
    is_deed: bool
    mended: tuple[bool, ...]
    parts: int = 0

    def is_possible(self, state: State) -> bool:
        """Whether no check forbids it."""
        return self.operator.is_possible(state, self.operator.bind(state, self.action.arguments))

    def after(self, state: State) -> State:
        """The state after it, whatever its checks say."""
        return self.operator.apply(state, self.operator.bind(state, self.action.arguments))

    def failing(self, state: State) -> list[int]:
        """The numbers of the checks that fail; after the last of them is that of what is tried in vain."""
        binding = self.operator.bind(state, self.action.arguments)
        checks = self.operator.checks
        found = [i for i, check in enumerate(checks) if not check.holds(state, binding)]
        return found if found or self.operator.is_possible(state, binding) else [len(checks)]

    def is_hopeless(self, failing: Sequence[int]) -> bool:
        """Whether a check that fails asks for objects of another kind."""
        checks = self.operator.checks
        return any(checks[i].check.fault is FaultKind.AFFORDANCE for i in failing if i < len(checks))


def is_needless(operator: CompiledOperator, action: Action, state: State) -> bool:
    """Whether an action says of itself that it is an additional step."""
    failures = operator.failures(state, operator.bind(state, action.arguments))
    return any(failure.check.check.fault is FaultKind.ADDITIONAL_STEP for failure in failures)


class Means(NamedTuple):
    """What may be done.

    Attributes:
        wanted: what may bring the subgoal about.
        helping: what may make that possible.
        moving: movement that may bring the subgoal about.
        movement: the operators that move the agent, by name.
        places: what the agent may move to.
    """

    wanted: Sequence[Ground]
    helping: Sequence[Ground]
    moving: Sequence[Ground]
    movement: Mapping[str, CompiledOperator]
    places: Sequence[int]


class Aim(NamedTuple):
    """What the search is for.

    Attributes:
        met: the mask of its parts that hold in a state, after an action.
        everything: the mask of all parts.
        holds: whether what it asks for besides its parts holds in a state.
        deeds: how many deeds may be done for it.
        told_apart: the operators of which it matters that they are taken, whatever state they lead to.
    """

    met: Callable[[State, Action | None], int]
    everything: int
    holds: Holds
    deeds: int
    told_apart: Collection[str]


class _Node(NamedTuple):
    """A state that was reached, the mask of the parts met there, the deeds that it took, and the way."""

    state: State
    met: int
    deeds: int
    plan: tuple[Action, ...]


class _Way(NamedTuple):
    """Actions, and the state after them."""

    plan: tuple[Action, ...]
    state: State


class Nearest(NamedTuple):
    """A plan that comes near an aim: how many parts it meets, how many checks its last action fails."""

    met: int
    failing: int
    plan: Plan

    @property
    def rank(self) -> tuple[int, int]:
        """Greater is nearer."""
        return self.met, -self.failing


class Refining:
    """A search by the length of plans.

    Args:
        aim: what it is for.
        means: what may be done.
        budget: how many actions may be applied to states for each deed.
    """

    def __init__(self, aim: Aim, means: Means, budget: int) -> None:
        self._aim = aim
        self._means = means
        self._budget = budget * aim.deeds
        self._nodes: list[_Node] = []
        self._ways: dict[State, _Ways] = {}

    def shortest(self, start: State) -> list[Plan]:
        """The shortest plans, as many as `MAX_PLANS`; no two to one state that the goal cannot tell apart.

        What lacks fewer parts is looked at first (`_A_PART` actions stand for a part), so that a plan for
        many parts may be a little longer than the shortest.
        """
        found: dict[object, Plan] = {}
        best: int | None = None
        queue = [(0, 0, _Node(start, self._aim.met(start, None), 0, ()))]
        lengths = {(start, 0): 0}
        numbers = count(1)
        while queue and self._budget > 0:
            _, _, node = heappop(queue)
            if best is not None and len(node.plan) >= best:
                break
            self._nodes.append(node)
            for child in self._children(node):
                length = len(child.plan)
                if best is not None and length > best:
                    continue
                if child.met == self._aim.everything and self._aim.holds(child.state):
                    found = found if length == best else {}
                    best = length
                    if len(found) < MAX_PLANS:
                        found.setdefault((child.state, self._told_apart(child.plan)), child.plan)
                elif length < lengths.get((child.state, child.deeds), length + 1):
                    lengths[child.state, child.deeds] = length
                    rank = length - _A_PART * child.met.bit_count()
                    heappush(queue, (rank, next(numbers), child))
        return list(found.values())

    def nearest(self) -> Nearest:
        """Of what `shortest` saw in vain what comes nearest to the aim, and the action that fails there.

        That is the one which lacks least of those that would help, or another one that would mend what it
        lacks. No action fails where each part can be reached, but not together with the others.
        """
        most = max([node.met.bit_count() for node in self._nodes])
        nodes = [node for node in self._nodes if node.met.bit_count() == most]
        attempts = [
            self._attempt(node, ground)
            for node in nodes
            for ground in (*self._means.wanted, *self._means.moving)
            if self._aim.met(ground.after(node.state), ground.action) & ~node.met & ground.parts
        ]
        if attempts and all(attempt.failing for attempt in attempts):
            best = min(attempts, key=lambda attempt: len(attempt.failing))
            return Nearest(most, len(best.failing), (self._cause(best) or best).plan)
        if not attempts:  # what would help needs something else first, or tries things in vain
            for ground in self._means.wanted:
                attempt = self._attempt(nodes[0], ground)
                vain = attempt if attempt.failing == [len(ground.operator.checks)] else None
                cause = self._cause(attempt) or vain
                if cause is not None:
                    return Nearest(most, len(cause.failing), cause.plan)
        return Nearest(most, 0, nodes[0].plan)

    def _children(self, node: _Node) -> Iterator[_Node]:
        for ground in (*self._means.wanted, *self._means.helping):
            deeds = node.deeds + ground.is_deed
            way = None if deeds > self._aim.deeds else self._approach(node.state, ground)
            if way is not None:
                self._budget -= 1
                after = ground.after(way.state)
                met = self._aim.met(after, ground.action)
                if met & ~node.met & ground.parts or not ground.is_deed:
                    yield _Node(after, met, deeds, (*node.plan, *way.plan, ground.action))
        if self._means.moving:
            for way in self._moved(node.state):
                met = self._aim.met(way.state, None)
                if met & ~node.met:
                    yield _Node(way.state, met, node.deeds, (*node.plan, *way.plan))

    def _approach(self, state: State, ground: Ground) -> _Way | None:
        """The shortest movement that makes an action possible; None if there is none."""
        if ground.is_possible(state):
            return _Way((), state)
        if not self._means.movement or not all(ground.mended[i] for i in ground.failing(state)):
            return None
        return next((way for way in self._moved(state) if ground.is_possible(way.state)), None)

    def _moved(self, state: State) -> Iterable[_Way]:
        """All that movement leads to, the shortest ways first; found as far as it is looked at."""
        ways = self._ways.get(state)
        if ways is None:
            ways = self._ways[state] = _Ways(self._move(state))
        return ways

    def _move(self, start: State) -> Iterator[_Way]:
        seen = {start}
        ways = [_Way((), start)]
        for _ in range(_MOST_MOVES):
            farther: list[_Way] = []
            for way in ways:
                taken = [action.operator for action in way.plan]
                for name, operator in self._means.movement.items():
                    if name in taken:
                        continue
                    for arguments in product(self._means.places, repeat=operator.operator.arity):
                        binding = operator.bind(way.state, arguments)
                        if self._budget > 0 and operator.is_possible(way.state, binding):
                            self._budget -= 1
                            after = operator.apply(way.state, binding)
                            if after not in seen:
                                seen.add(after)
                                farther.append(_Way((*way.plan, Action(name, arguments)), after))
                                yield farther[-1]
            ways = farther

    def _attempt(self, node: _Node, ground: Ground) -> _Attempt:
        """An action tried where, of all states that movement leads to, the fewest of its checks fail."""
        best = _Attempt(node, ground, (*node.plan, ground.action), node.state, ground.failing(node.state))
        for way in self._moved(node.state):
            failing = ground.failing(way.state)
            if len(failing) < len(best.failing):
                plan = (*node.plan, *way.plan, ground.action)
                best = _Attempt(node, ground, plan, way.state, failing)
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

    def _told_apart(self, plan: Plan) -> tuple[Action, ...]:
        return tuple([action for action in plan if action.operator in self._aim.told_apart])


class _Ways:
    """Ways as they are found, to be looked at again and again."""

    def __init__(self, ways: Iterator[_Way]) -> None:
        self._ways = ways
        self._found: list[_Way] = []

    def __iter__(self) -> Iterator[_Way]:
        yield from self._found
        for way in self._ways:
            self._found.append(way)
            yield way


class _Attempt(NamedTuple):
    """An action that fails: where, after what, and the numbers of the checks that do."""

    node: _Node
    ground: Ground
    plan: tuple[Action, ...]
    state: State
    failing: list[int]
