"""Relaxed planning: how far is a state from the goal if nothing true, and nothing false, is ever lost?

A relaxed state is a set of literals, which only grows (`literals`). One thing is lost all the same: an atom
of the goal that is true now, but that every way to a part of the goal still missing makes false. It has to be
made true once more, which is the reason why a machine is not switched on before its door is closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple

from eai.pddl.grounding import ALWAYS, GroundAction, GroundCondition
from eai.pddl.literals import Literals, bits, grouped
from eai.pddl.successors import looks_for
from eai.planning.effort import Effort

_EVERYTHING = -1
"""More literals than there are."""


class Rule(NamedTuple):
    """One conditional effect of the action of this number: the literals that it needs and that it makes."""

    action: int
    needs: int
    makes: int


class _Lacking(NamedTuple):
    """A literal that is not reached, the rules that need it, and those that make it."""

    literal: int
    needing: int
    making: int


class Layers(NamedTuple):
    """Relaxed states one step apart, and the sets of the rules that lead from each to the next."""

    reached: list[int]
    fired: list[int]


class Estimate(NamedTuple):
    """A relaxed plan: how many actions it has, and the set of its actions that can be taken at once."""

    length: int
    helpful: int


class Relaxation:
    """Relaxed planning for one set of ground actions and one goal.

    Args:
        actions: the ground actions, numbered in order.
        goal: the goal.
        literals: what their conditions are about.
        looks: how many literals may be looked at: that is what estimates cost. Where they are used up, what
            is found means nothing.
    """

    def __init__(
        self, actions: Sequence[GroundAction], goal: GroundCondition, literals: Literals, looks: Effort
    ) -> None:
        self._looks = looks
        self._literals = literals
        self._again = 2 * literals.atoms
        self._goal = literals.needs(goal)
        self._prices = _prices(actions, goal)
        self._rules = [
            Rule(
                number,
                literals.needs(action.precondition) | literals.needs(change.condition),
                change.add | change.delete << literals.atoms,
            )
            for number, action in enumerate(actions)
            for change in action.changes
        ]
        self._price = looks_for(len(self._rules))
        self._making = grouped([rule.makes for rule in self._rules])
        needing = grouped([rule.needs for rule in self._rules])
        asked = literals.mentioned(reduce(or_, [rule.needs for rule in self._rules], self._goal))
        self._asked = [
            _Lacking(literal, needing.get(literal, 0), self._making.get(literal, 0))
            for literal in bits(asked)
        ]

    def estimate(self, state: int, literals: int) -> Estimate | None:
        """A relaxed plan from a state, in which these literals are, or None if there is none.

        Then there is no plan at all.
        """
        again = self._to_be_lost(state)
        goal = self._goal | again << self._again
        layers = self._explore(literals, goal, again)
        return self._plan(goal, layers) if not goal & ~layers.reached[-1] else None

    def _to_be_lost(self, state: int) -> int:
        """The goal's atoms that are true now and will be false before the whole goal holds."""
        missing = self._goal & ~state
        lost = 0
        for bit, price in self._prices.items():
            if missing & bit:
                lost |= price
        return lost & state

    def _explore(self, start: int, goal: int, again: int) -> Layers:
        """Relaxed states until the goal is there, or until nothing more grows, or may be looked at.

        The atoms that are to be made true ``again`` are literals of their own.
        """
        literals = start
        lacking = [each for each in self._asked if not literals & each.literal]
        lacking += [_Lacking(bit << self._again, 0, self._making.get(bit, 0)) for bit in bits(again)]
        layers, waiting = Layers([literals], []), (1 << len(self._rules)) - 1
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
                literals = self._literals.with_choices(literals)
                lacking = [each for each in lacking if not literals & each.literal]
            layers.fired.append(fired)
            layers.reached.append(literals)
            if literals == before:
                break
        return layers

    def _plan(self, goal: int, layers: Layers) -> Estimate:
        """Walk back from the goal, crediting every literal to the first rule that reaches it."""
        chosen, helpful = set[int](), 0
        needed = self._literals.chosen(goal, layers.reached[-1])
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
                needed |= self._literals.chosen(needs, before)
        return Estimate(len(chosen), helpful)

    def layers(self, literals: int) -> Layers:
        """All relaxed states from one in which these literals are, until nothing more grows."""
        return self._explore(literals, _EVERYTHING, 0)

    def makers(self, literal: int, rules: int) -> Iterator[Rule]:
        """Those of some rules, a set of their numbers, that make a literal, in order."""
        for bit in bits(self._making.get(literal, 0) & rules):
            yield self._rules[bit.bit_length() - 1]

    def _first(self, missing: int, fired: int) -> Rule:
        """The first of some rules that makes any of the missing literals."""
        making = 0
        for literal in bits(missing):
            making |= self._making.get(literal) or self._making.get(literal >> self._again, 0)
        making &= fired
        return self._rules[(making & -making).bit_length() - 1]


def _prices(actions: Sequence[GroundAction], goal: GroundCondition) -> dict[int, int]:
    """For each atom of the goal (as a bit) the goal's atoms that every action adding it makes false."""
    prices: dict[int, int] = {}
    for action in actions:
        adds = deletes = 0
        for change in action.changes:
            adds |= change.add
            if change.condition == ALWAYS:
                deletes |= change.delete
        lost = deletes & ~adds & goal.true
        for bit in bits(adds & goal.true):
            prices[bit] = prices.get(bit, goal.true) & lost
    return {bit: price for bit, price in prices.items() if price}
