"""Relaxed planning: how far is a state from the goal if nothing true, and nothing false, is ever lost?

A relaxed state is a set of literals, which only grows (`grounding`). One thing is lost all the same: an atom
of the goal that is true now, but that every way to a part of the goal still missing makes false. It has to be
made true once more, which is the reason why a machine is not switched on before its door is closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple, TypeAlias

from eai.pddl.grounding import GroundProblem, bits, count_looks, group_by_bit
from eai.planning.search import Effort

_ALL_LITERALS = -1
"""More literals than there are."""

_MAX_ROUNDS = 2
"""How often literals that are needed together are made true, where one is lost while another is made."""

_MAX_REPEAT_DEPTH = 2
"""How many actions deep what was true at the start, and is lost, is made true again."""

_MAX_RULES = 2_000
"""How many rules one lookahead may try."""


class _LiteralRule(NamedTuple):
    """One conditional effect of the action of this number: the literals that it needs and that it makes."""

    action: int
    needs: int
    makes: int


class _Lacking(NamedTuple):
    """A literal that is not reached, the rules that need it, and those that make it."""

    literal: int
    needing: int
    making: int


class _Layers(NamedTuple):
    """Relaxed states one step apart, and the sets of the rules that lead from each to the next."""

    reached: list[int]
    fired: list[int]


class _RelaxedPlan(NamedTuple):
    """A relaxed plan: how many actions it has, and the set of its actions that can be taken at once."""

    length: int
    helpful: int


class Relaxation:
    """Relaxed planning for one ground problem.

    Args:
        problem: the problem.
        looks: how many literals may be looked at: that is what estimates cost. Where they are used up, what
            is found means nothing.
    """

    def __init__(self, problem: GroundProblem, looks: Effort) -> None:
        self._looks = looks
        self._problem = problem
        self._again = 2 * problem.atoms
        self._prices = _prices(problem)
        self._rules = [
            _LiteralRule(number, action.needs | change.needs, change.add | change.delete << problem.atoms)
            for number, action in enumerate(problem.actions)
            for change in action.changes
        ]
        self._price = count_looks(len(self._rules))
        self._making = group_by_bit([rule.makes for rule in self._rules])
        needing = group_by_bit([rule.needs for rule in self._rules])
        asked = problem.mention_all(reduce(or_, [rule.needs for rule in self._rules], problem.goal))
        self._asked = [
            _Lacking(literal, needing.get(literal, 0), self._making.get(literal, 0))
            for literal in bits(asked)
        ]

    def estimate(self, state: int, literals: int) -> _RelaxedPlan | None:
        """A relaxed plan from a state, in which these literals are, or None if there is none.

        Then there is no plan at all.
        """
        again = self._find_lost(state)
        goal = self._problem.goal | again << self._again
        layers = self._explore(literals, goal, again)
        return self._plan(goal, layers) if not goal & ~layers.reached[-1] else None

    def _find_lost(self, state: int) -> int:
        """The goal's atoms that are true now and will be false before the whole goal holds."""
        missing = self._problem.goal & ~state
        lost = 0
        for bit, price in self._prices.items():
            if missing & bit:
                lost |= price
        return lost & state

    def _explore(self, start: int, goal: int, again: int) -> _Layers:
        """Relaxed states until the goal is there, or until nothing more grows, or may be looked at.

        The atoms that are to be made true ``again`` are literals of their own.
        """
        literals = start
        lacking = [each for each in self._asked if not literals & each.literal]
        lacking += [_Lacking(bit << self._again, 0, self._making.get(bit, 0)) for bit in bits(again)]
        layers, waiting = _Layers([literals], []), (1 << len(self._rules)) - 1
        looks = self._looks
        while goal & ~literals and not looks.is_exceeded:
            looks.used += self._price * len(lacking)
            kept = 0
            for _, needing, _ in lacking:
                kept |= needing
            fired = waiting & ~kept
            waiting &= kept
            before = literals
            for literal, _, making in lacking:
                if making & fired:
                    literals |= literal
            if literals != before:
                literals = self._problem.add_choices(literals)
                lacking = [each for each in lacking if not literals & each.literal]
            layers.fired.append(fired)
            layers.reached.append(literals)
            if literals == before:
                break
        return layers

    def _plan(self, goal: int, layers: _Layers) -> _RelaxedPlan:
        """Walk back from the goal, crediting every literal to the first rule that reaches it."""
        chosen, helpful = set[int](), 0
        needed = self._problem.choose(goal, layers.reached[-1])
        for depth in range(len(layers.fired) - 1, -1, -1):
            before, fired = layers.reached[depth], layers.fired[depth]
            missing = needed & ~before
            needed &= before
            while missing:
                action, needs, makes = self._first(missing, fired)
                missing &= ~(makes | makes << self._again)
                chosen.add(action)
                if depth == 0:
                    helpful |= 1 << action
                needed |= self._problem.choose(needs, before)
        return _RelaxedPlan(len(chosen), helpful)

    def layers(self, literals: int) -> _Layers:
        """All relaxed states from one in which these literals are, until nothing more grows."""
        return self._explore(literals, _ALL_LITERALS, 0)

    def makers(self, literal: int, rules: int) -> Iterator[_LiteralRule]:
        """Those of some rules, a set of their numbers, that make a literal, in order."""
        for bit in bits(self._making.get(literal, 0) & rules):
            yield self._rules[bit.bit_length() - 1]

    def _first(self, missing: int, fired: int) -> _LiteralRule:
        """The first of some rules that makes any of the missing literals."""
        making = 0
        for literal in bits(missing):
            making |= self._making.get(literal) or self._making.get(literal >> self._again, 0)
        making &= fired
        return self._rules[(making & -making).bit_length() - 1]


def _prices(problem: GroundProblem) -> dict[int, int]:
    """For each atom of the goal (as a bit) the goal's atoms that every action adding it makes false."""
    goal = problem.goal & (1 << problem.atoms) - 1
    prices: dict[int, int] = {}
    for action in problem.actions:
        adds = deletes = 0
        for change in action.changes:
            adds |= change.add
            if not change.needs:
                deletes |= change.delete
        lost = deletes & ~adds & goal
        for bit in bits(adds & goal):
            prices[bit] = prices.get(bit, goal) & lost
    return {bit: price for bit, price in prices.items() if price}


_Mark: TypeAlias = tuple[int, int, int]
"""How many actions were taken at some time, and the state and literals then."""


def look_ahead(
    problem: GroundProblem, relaxation: Relaxation, state: int, literals: int
) -> Sequence[tuple[int, int]]:
    """Actions from a state, in which these literals are, after which less of the goal is missing.

    Each is a number, with the state after it.

    They are relaxed planning carried out (after Vidal 2004). A relaxed plan forgets that what is true may be
    lost: it goes but once to where many things have to be brought. Here each literal is made true just before
    the action that needs it, and once more where it has been lost since. The state that this leads to is
    often the goal, or nearly so.
    """
    return _Lookahead(problem, relaxation, state, literals).run()


class _Lookahead:
    """The state that a lookahead has come to."""

    def __init__(self, problem: GroundProblem, relaxation: Relaxation, state: int, literals: int) -> None:
        self._problem = problem
        self._relaxation = relaxation
        self._rules_left = _MAX_RULES
        self._layers = relaxation.layers(literals)
        self._state, self._start, self._held = state, literals, literals
        self._taken: list[tuple[int, int]] = []

    def run(self) -> Sequence[tuple[int, int]]:
        """Gain what is missing of the goal, in turn, until no more of it can be gained."""
        before = None
        while (goal := self._problem.goal & ~self._held) and (missing := self._missing()) != before:
            before = missing
            for literal in self._order(goal, len(self._layers.fired)):
                if not self._held & literal:
                    self._gain(literal)
        return self._taken

    def _missing(self) -> tuple[int, int]:
        """How much of the goal is missing: of what was not so at the start, and in all."""
        missing = self._problem.goal & ~self._held
        return (missing & ~self._start).bit_count(), missing.bit_count()

    def _gain(self, literal: int) -> None:
        """Make a literal of the goal true by the first rule that leaves less of it missing; or by none."""
        missing, mark = self._missing(), self._mark()
        for depth, fired in enumerate(self._layers.fired):
            for rule in self._relaxation.makers(literal, fired):
                if self._follow(rule, depth) and self._missing() < missing:
                    return
                self._return_to(mark)

    def _follow(self, rule: _LiteralRule, depth: int) -> bool:
        """Take the action of a rule of a layer, after what it needs; whether that is possible."""
        self._rules_left -= 1
        if self._rules_left < 0 or not self._make(rule.needs, depth):
            return False
        self._state = self._problem.apply(rule.action, self._state, self._held)
        self._held = self._problem.literals_of(self._state)
        self._taken.append((rule.action, self._state))
        return True

    def _make(self, needed: int, depth: int) -> bool:
        """Make literals true together by rules of the layers before one; whether all are true in the end.

        Those that take longest come first, or else last.
        """
        mark = self._mark()
        for last in (False, True):
            for _ in range(_MAX_ROUNDS):
                missing = self._order(needed & ~self._held, depth)
                for literal in missing[::-1] if last else missing:
                    if not self._held & literal:
                        self._make_one(literal, depth)
                if not needed & ~self._held:
                    return True
            self._return_to(mark)
        return False

    def _make_one(self, literal: int, depth: int) -> None:
        """Make a literal true by the first rule of the layers before one; if it was lost, of the first."""
        for before, fired in enumerate(self._layers.fired[: max(depth, int(depth > -_MAX_REPEAT_DEPTH))]):
            for rule in self._relaxation.makers(literal, fired):
                self._follow(rule, min(before, depth - 1))
                return

    def _order(self, missing: int, depth: int) -> list[int]:
        """Literals that are missing, those first that take longest to reach."""
        missing, found = self._problem.choose(missing, self._layers.reached[max(depth, 0)]), list[int]()
        for reached in self._layers.reached[max(depth, 0) :: -1]:
            found += bits(missing & ~reached)
            missing &= reached
        return [*found, *bits(missing)]

    def _mark(self) -> _Mark:
        return len(self._taken), self._state, self._held

    def _return_to(self, mark: _Mark) -> None:
        """Forget all actions since then."""
        taken, self._state, self._held = mark
        del self._taken[taken:]
