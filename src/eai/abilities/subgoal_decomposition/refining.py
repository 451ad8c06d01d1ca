"""One search for the actions that carry out a subgoal from a state: for what, `refinement` says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush
from itertools import count, product
from typing import NamedTuple

from eai.abilities.subgoal_decomposition.program import Plan
from eai.abilities.subgoal_decomposition.repertoire import Holds, Known
from eai.world.executable import CompiledOperator
from eai.world.execution import Action
from eai.world.fault import FaultKind
from eai.world.frame import Binding
from eai.world.operator import Role
from eai.world.state import State

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
        known: its operator.
        binding: the operator's variables for its objects; for one search alone.
        parts: the mask of the parts of the aim that it is for; 0 if it helps another one.
        touched: the mask of the parts that it can change.
    """

    action: Action
    known: Known
    binding: Binding
    parts: int
    touched: int

    @property
    def is_deed(self) -> bool:
        """Whether it counts as a deed."""
        return self.known.role is Role.DEED

    def is_possible(self, state: State) -> bool:
        """Whether no check forbids it."""
        return self.known.operator.is_possible(state, self.binding)

    def after(self, state: State) -> State:
        """The state after it, whatever its checks say."""
        return self.known.operator.apply(state, self.binding)

    def failing(self, state: State) -> list[int]:
        """The numbers of the checks that fail; after the last of them is that of what is tried in vain."""
        checks = self.known.operator.checks
        found = [i for i, check in enumerate(checks) if not check.holds(state, self.binding)]
        return found if found or self.is_possible(state) else [len(checks)]

    def is_hopeless(self, failing: Sequence[int]) -> bool:
        """Whether a check that fails asks for objects of another kind."""
        checks = self.known.operator.checks
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
        touched: the mask of the parts that movement can change.
        places: what the agent may move to.
    """

    wanted: Sequence[Ground]
    helping: Sequence[Ground]
    moving: Sequence[Ground]
    movement: Mapping[str, CompiledOperator]
    touched: int
    places: Sequence[int]


class Aim(NamedTuple):
    """What the search is for.

    Attributes:
        at_start: the mask of its parts that hold where the search begins.
        met: the mask of those that hold in a state: of the parts in a mask they are looked at, of the others
            it is those of another mask.
        everything: the mask of all parts.
        holds: whether what it asks for besides its parts holds in a state.
        deeds: how many deeds may be done for it.
        told_apart: the operators of which it matters that they are taken, whatever state they lead to.
        effort: how many applied actions a test of `holds` stands for.
    """

    at_start: int
    met: Callable[[State, int, int], int]
    everything: int
    holds: Holds
    deeds: int
    told_apart: Collection[str]
    effort: int = 0


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
        budget: how many actions may be applied to states.
    """

    def __init__(self, aim: Aim, means: Means, budget: int) -> None:
        self._aim = aim
        self._means = means
        self._budget = budget
        self._allowed = budget
        self._nodes: list[_Node] = []
        self._ways: dict[State, _Ways] = {}
        self._out_of_reach: set[tuple[State, Action]] = set()

    @property
    def effort(self) -> int:
        """How many actions have been applied to states."""
        return self._allowed - self._budget

    def shortest(self, start: State) -> list[Plan]:
        """The shortest plans, at most `MAX_PLANS`; no two to one state that the goal cannot tell apart.

        What lacks fewer parts is looked at first (`_A_PART` actions stand for a part), so that a plan for
        many parts may be a little longer than the shortest.
        """
        found: dict[object, Plan] = {}
        best: int | None = None
        queue = [(0, 0, _Node(start, self._aim.at_start, 0, ()))]
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
                if child.met == self._aim.everything and self._holds(child.state):
                    found = found if length == best else {}
                    best = length
                    found.setdefault((child.state, self._told_apart(child.plan)), child.plan)
                    if len(found) == MAX_PLANS:
                        return list(found.values())
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
        best: _Attempt | None = None
        for node in nodes:
            for ground in (*self._means.wanted, *self._means.moving):
                missing = ground.parts & ~node.met
                if missing and self._met_after(node, ground) & missing:
                    attempt = self._attempt(node, ground, best)
                    if not attempt.failing:
                        return Nearest(most, 0, nodes[0].plan)
                    if best is None or len(attempt.failing) < len(best.failing):
                        best = attempt
        if best is not None:
            return Nearest(most, len(best.failing), (self._cause(best) or best).plan)
        for ground in self._means.wanted:  # what would help needs something else first, or tries in vain
            attempt = self._attempt(nodes[0], ground)
            vain = attempt if attempt.failing == [len(ground.known.operator.checks)] else None
            cause = self._cause(attempt) or vain
            if cause is not None:
                return Nearest(most, len(cause.failing), cause.plan)
        return Nearest(most, 0, nodes[0].plan)

    def _holds(self, state: State) -> bool:
        """Whether all that is asked for holds; a long formula costs as much as it is long."""
        self._budget -= self._aim.effort
        return self._aim.holds(state)

    def _children(self, node: _Node) -> Iterator[_Node]:
        for ground in (*self._means.wanted, *self._means.helping):
            is_deed = ground.is_deed
            deeds = node.deeds + is_deed
            if deeds > self._aim.deeds or (is_deed and not ground.parts & ~node.met):
                continue
            way = self._approach(node.state, ground)
            if way is not None:
                self._budget -= 1
                after = ground.after(way.state)
                touched = ground.touched | (self._means.touched if way.plan else 0)
                met = self._aim.met(after, touched, node.met)
                if not is_deed or met & ~node.met & ground.parts:
                    yield _Node(after, met, deeds, (*node.plan, *way.plan, ground.action))
        if self._means.moving:
            for way in self._moved(node.state):
                met = self._aim.met(way.state, self._means.touched, node.met)
                if met & ~node.met:
                    yield _Node(way.state, met, node.deeds, (*node.plan, *way.plan))

    def _met_after(self, node: _Node, ground: Ground) -> int:
        """The mask of the parts that are met after an action, were it possible."""
        return self._aim.met(ground.after(node.state), ground.touched, node.met)

    def _approach(self, state: State, ground: Ground) -> _Way | None:
        """The shortest movement that makes an action possible; None if there is none."""
        if ground.is_possible(state):
            return _Way((), state)
        if not self._means.movement or not all(ground.known.mended[i] for i in ground.failing(state)):
            return None
        for way in self._moved(state):
            if ground.is_possible(way.state):
                return way
        self._out_of_reach.add((state, ground.action))
        return None

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

    def _attempt(self, node: _Node, ground: Ground, other: _Attempt | None = None) -> _Attempt:
        """An action tried where, of all states that movement leads to, the fewest of its checks fail.

        Movement is not looked at where it cannot make fewer fail than in the ``other`` attempt.
        """
        failing = ground.failing(node.state)
        best = _Attempt(node, ground, (*node.plan, ground.action), node.state, failing)
        least = sum([not ground.known.moved[i] for i in failing])
        if not least and (node.state, ground.action) in self._out_of_reach:
            least = 1
        if other is not None and least >= len(other.failing):
            return best
        if len(failing) > least:
            for way in self._moved(node.state):
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
