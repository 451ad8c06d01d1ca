"""Relaxed planning: how far is a state from the goal if nothing true, and nothing false, is ever lost?

A relaxed state is a pair of masks: the atoms that may be true and those that may be false. Both only grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from eai.pddl.execute import Step
from eai.pddl.grounding import Condition, GroundAction


class _Rule(NamedTuple):
    """One conditional effect of one action."""

    action: GroundAction
    precondition: Condition
    condition: Condition
    add: int
    delete: int


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
    helpful: frozenset[Step]


class Relaxation:
    """Relaxed planning for one set of ground actions and one goal."""

    def __init__(self, actions: Sequence[GroundAction], goal: Condition) -> None:
        self._goal = goal
        self._actions = actions
        self._rules = [
            _Rule(action, action.precondition, change.condition, change.add, change.delete)
            for action in actions
            for change in action.changes
        ]

    def reachable(self, state: int) -> list[GroundAction]:
        """The actions that can ever be taken from a state on, in order."""
        true, false = state, ~state
        waiting = self._rules
        while True:
            rest = []
            grown_true, grown_false = true, false
            for rule in waiting:
                if _may_hold(rule.precondition, true, false) and _may_hold(rule.condition, true, false):
                    grown_true |= rule.add
                    grown_false |= rule.delete
                else:
                    rest.append(rule)
            if grown_true == true and grown_false == false:
                break
            true, false, waiting = grown_true, grown_false, rest
        return [action for action in self._actions if _may_hold(action.precondition, true, false)]

    def estimate(self, state: int) -> Estimate | None:
        """A relaxed plan from a state, or None if there is none: then there is no plan at all."""
        layers = [_Layer(state, ~state)]
        fired: list[list[_Rule]] = []
        waiting = self._rules
        while not _may_hold(self._goal, *layers[-1]):
            true, false = layers[-1]
            new, rest = [], []
            grown_true, grown_false = true, false
            for rule in waiting:
                if _may_hold(rule.precondition, true, false) and _may_hold(rule.condition, true, false):
                    if rule.add & ~true or rule.delete & ~false:
                        new.append(rule)
                        grown_true |= rule.add
                        grown_false |= rule.delete
                else:
                    rest.append(rule)
            if not new:
                return None
            waiting = rest
            fired.append(new)
            layers.append(_Layer(grown_true, grown_false))
        return _extract(self._goal, layers, fired)


def _may_hold(condition: Condition, true: int, false: int) -> bool:
    if condition.true & ~true or condition.false & ~false:
        return False
    if not condition.choices:
        return True
    return all(any(_may_hold(part, true, false) for part in choice) for choice in condition.choices)


def _extract(goal: Condition, layers: Sequence[_Layer], fired: Sequence[Sequence[_Rule]]) -> Estimate:
    """Walk back from the goal, crediting every atom to the first rule that reaches it."""
    chosen: set[Step] = set()
    helpful: set[Step] = set()
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
            for condition in (rule.precondition, rule.condition):
                need = _needs(condition, before)
                true |= need.true
                false |= need.false
            if not missing_true and not missing_false:
                break
    return Estimate(len(chosen), frozenset(helpful))


def _needs(condition: Condition, layer: _Layer) -> _Need:
    """The atoms that a condition asks for, with the first possible option of every choice."""
    true, false = condition.true, condition.false
    for choice in condition.choices:
        option = next(part for part in choice if _may_hold(part, *layer))
        need = _needs(option, layer)
        true |= need.true
        false |= need.false
    return _Need(true, false)
