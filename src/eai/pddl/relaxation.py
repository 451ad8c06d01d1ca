"""Relaxed planning: how far is a state from the goal if nothing true, and nothing false, is ever lost?

A relaxed state is a pair of masks: the atoms that may be true and those that may be false. Both only grow.
One thing is lost all the same: an atom of the goal that is true now, but that every way to a part of the
goal still missing makes false. It has to be made true once more, which is the reason why a machine is not
switched on before its door is closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from eai.pddl.execute import PlanStep
from eai.pddl.grounding import ALWAYS, GroundAction, GroundCondition
from eai.pddl.looks import Looks


class _Rule(NamedTuple):
    """One conditional effect of one action, with all that it needs, in so many alternatives."""

    action: GroundAction
    condition: GroundCondition
    add: int
    delete: int
    alternatives: int


class _Rules(NamedTuple):
    """Rules of one action, and what they all need."""

    precondition: GroundCondition
    rules: Sequence[_Rule]


class _Layer(NamedTuple):
    """What may be true and what may be false after so many steps."""

    true: int
    false: int


class _Need(NamedTuple):
    """Atoms that must be made true and atoms that must be made false."""

    true: int
    false: int


@dataclass(frozen=True, slots=True)
class Estimate:
    """A relaxed plan: how many actions it has, and its actions that can be taken at once."""

    length: int
    helpful: frozenset[PlanStep]


class Relaxation:
    """Relaxed planning for one set of ground actions and one goal.

    Args:
        actions: the ground actions.
        goal: the goal.
        atoms: how many atoms there are.
        looks: how many effects of actions, and alternatives in their conditions, may be looked at: that is
            what estimates cost. Where they are used up, what is found means nothing.
    """

    def __init__(
        self, actions: Sequence[GroundAction], goal: GroundCondition, atoms: int, looks: Looks | None = None
    ) -> None:
        self._looks = looks or Looks()
        self._goal = goal
        self._actions = actions
        self._atoms = atoms
        self._prices = _prices(actions, goal)
        self._rules = [_Rules(action.precondition, _rules(action)) for action in actions]

    def reachable(self, state: int) -> list[GroundAction]:
        """The actions that can ever be taken from a state on, in order."""
        layers, _ = self._explore(self._rules, _Layer(state, ~state), until=None)
        return [action for action in self._actions if _may_hold(action.precondition, *layers[-1])]

    def estimate(self, state: int) -> Estimate | None:
        """A relaxed plan from a state, or None if there is none: then there is no plan at all."""
        again = self._to_be_lost(state)
        goal, rules = self._goal, self._rules
        if again:
            goal = goal._replace(true=goal.true | again << self._atoms)
            rules = [
                _Rules(precondition, [_marking(rule, again, self._atoms) for rule in marked])
                for precondition, marked in rules
            ]
            self._looks.used += sum([len(marked) for _, marked in rules])
        layers, fired = self._explore(rules, _Layer(state, ~state), until=goal)
        return _extract(goal, layers, fired) if _may_hold(goal, *layers[-1]) else None

    def _to_be_lost(self, state: int) -> int:
        """The goal's atoms that are true now and will be false before the whole goal holds."""
        missing = self._goal.true & ~state
        lost = 0
        for bit, price in self._prices.items():
            if missing & bit:
                lost |= price
        return lost & state

    def _explore(
        self, waiting: Sequence[_Rules], start: _Layer, until: GroundCondition | None
    ) -> tuple[list[_Layer], list[list[_Rule]]]:
        """Relaxed states one step apart, and the rules that lead from each to the next.

        Ends when a condition may hold, or when nothing more grows, or may be looked at.
        """
        layers, fired = [start], list[list[_Rule]]()
        looks = self._looks
        while (until is None or not _may_hold(until, *layers[-1])) and not looks.are_used_up:
            true, false = layers[-1]
            not_true, not_false = ~true, ~false
            new, rest = list[_Rule](), list[_Rules]()
            grown_true, grown_false = true, false
            looks.used += len(waiting)
            for group in waiting:
                precondition, rules = group
                if not _may_hold(precondition, true, false):
                    rest.append(group)
                    continue
                left = list[_Rule]()
                looks.used += len(rules)
                for rule in rules:
                    needed_true, needed_false, choices = rule.condition
                    if needed_true & not_true or needed_false & not_false:
                        left.append(rule)
                        continue
                    if choices:
                        looks.used += rule.alternatives
                        if not _may_hold(rule.condition, true, false):
                            left.append(rule)
                            continue
                    if rule.add & not_true or rule.delete & not_false:
                        new.append(rule)
                        grown_true |= rule.add
                        grown_false |= rule.delete
                if left:
                    rest.append(_Rules(ALWAYS, left))
            if not new:
                break
            waiting = rest
            fired.append(new)
            layers.append(_Layer(grown_true, grown_false))
        return layers, fired


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
        for bit in _bits(adds & goal.true):
            prices[bit] = prices.get(bit, goal.true) & lost
    return {bit: price for bit, price in prices.items() if price}


def _bits(mask: int) -> Iterator[int]:
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit


def _both(first: GroundCondition, second: GroundCondition) -> GroundCondition:
    return GroundCondition(
        first.true | second.true, first.false | second.false, first.choices + second.choices
    )


def _rules(action: GroundAction) -> list[_Rule]:
    """The rules of an action, one for each of its effects."""
    rules = []
    for change in action.changes:
        condition = _both(action.precondition, change.condition)
        rules.append(_Rule(action, condition, change.add, change.delete, _alternatives(condition)))
    return rules


def _alternatives(condition: GroundCondition) -> int:
    """How many alternatives all the choices of a condition have together."""
    return sum([1 + _alternatives(part) for choice in condition.choices for part in choice])


def _marking(rule: _Rule, again: int, atoms: int) -> _Rule:
    """The rule with a second atom for each atom to be made true again, beyond all others."""
    marked = rule.add & again
    return rule._replace(add=rule.add | marked << atoms) if marked else rule


def _may_hold(condition: GroundCondition, true: int, false: int) -> bool:
    not_true, not_false = ~true, ~false
    if condition.true & not_true or condition.false & not_false:
        return False
    for choice in condition.choices:  # in loops: this is asked more often than anything else
        for needed_true, needed_false, choices in choice:
            if needed_true & not_true or needed_false & not_false:
                continue
            if not choices or _may_hold(GroundCondition(0, 0, choices), true, false):
                break
        else:
            return False
    return True


def _extract(goal: GroundCondition, layers: Sequence[_Layer], fired: Sequence[Sequence[_Rule]]) -> Estimate:
    """Walk back from the goal, crediting every atom to the first rule that reaches it."""
    chosen: set[PlanStep] = set()
    helpful: set[PlanStep] = set()
    true, false = _needs(goal, layers[-1])
    for depth in range(len(fired) - 1, -1, -1):
        before = layers[depth]
        missing_true, missing_false = true & ~before.true, false & ~before.false
        true &= before.true
        false &= before.false
        for rule in fired[depth]:
            if not (rule.add & missing_true or rule.delete & missing_false):
                continue
            missing_true &= ~rule.add
            missing_false &= ~rule.delete
            chosen.add(rule.action.step)
            if depth == 0:
                helpful.add(rule.action.step)
            need = _needs(rule.condition, before)
            true |= need.true
            false |= need.false
            if not missing_true and not missing_false:
                break
    return Estimate(len(chosen), frozenset(helpful))


def _needs(condition: GroundCondition, layer: _Layer) -> _Need:
    """The atoms that a condition asks for, with the first possible option of every choice."""
    true, false = condition.true, condition.false
    for choice in condition.choices:
        option = next(part for part in choice if _may_hold(part, *layer))
        need = _needs(option, layer)
        true |= need.true
        false |= need.false
    return _Need(true, false)
