"""Reachable pairs: which literals may hold together (h2; Haslum and Geffner 2000).

That a hand which holds one thing holds no other is a statement on pairs, which a relaxed plan forgets. Two
literals may hold together at the start, or after an action that makes one of them and makes or keeps the
other. Choices in conditions are left out, and conditional effects that may take place may do so together:
more pairs are found than there are, never fewer. So a goal with a pair that is not found has no plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from eai.pddl.grounding import ALWAYS, GroundAction, GroundChange, GroundCondition
from eai.pddl.literals import bits
from eai.planning.effort import Effort


class _Rule(NamedTuple):
    """A conditional effect: what it needs and makes, what always and perhaps is made too, what is lost."""

    needs: int
    makes: int
    always: int
    perhaps: int
    lost: int


class Pairs:
    """The pairs of literals that may hold together in a state that actions lead to from a first one.

    Args:
        actions: the ground actions.
        atoms: how many atoms there are; the literals of each are numbered as in `Literals`.
        initial: the first state.
        looks: how many literals may be looked at. Where they are used up, what is found means nothing.
    """

    def __init__(self, actions: Sequence[GroundAction], atoms: int, initial: int, looks: Effort) -> None:
        self._atoms = atoms
        self._every_atom = (1 << atoms) - 1
        self._looks = looks
        self._reached = initial | (~initial & self._every_atom) << atoms
        self._beside = dict.fromkeys(bits(self._reached), self._reached)
        rules = [rule for action in actions for rule in self._rules(action)]
        while self._grow(rules):
            pass

    def allow(self, condition: GroundCondition) -> bool:
        """Whether all that a condition needs may hold together, as far as pairs tell."""
        return self._looks.is_exceeded or self._with(self._needs(condition)) is not None

    def _rules(self, action: GroundAction) -> Iterator[_Rule]:
        always = perhaps = 0
        for change in action.changes:
            if change.condition == ALWAYS:
                always |= self._makes(change)
            else:
                perhaps |= self._makes(change)
        for change in action.changes:
            needs, makes = (
                self._needs(action.precondition) | self._needs(change.condition),
                self._makes(change),
            )
            yield _Rule(needs, makes, always, perhaps, self._denied(makes | always))

    def _grow(self, rules: Sequence[_Rule]) -> bool:
        """Add the pairs that effects make, in turn; whether there are any new ones."""
        grew = False
        for rule in rules:
            if self._looks.is_exceeded:
                return False
            grew |= self._apply(rule)
        return grew

    def _apply(self, rule: _Rule) -> bool:
        """Add the pairs that one effect makes."""
        kept = self._with(rule.needs)
        if kept is None:
            return False
        together = kept & ~rule.lost | rule.makes | rule.always | rule.perhaps & self._reached
        grew = False
        for literal in bits(rule.makes):
            new = together & ~self._beside.get(literal, 0) & ~self._denied(literal)
            if new:
                grew = True
                self._beside[literal] = self._beside.get(literal, 0) | new
                for other in bits(new):
                    self._beside[other] = self._beside.get(other, 0) | literal
                self._reached |= new
                self._looks.used += new.bit_count()
        return grew

    def _with(self, needed: int) -> int | None:
        """The literals that may hold together with each of those that are needed; None if those may not."""
        self._looks.used += 1 + needed.bit_count()
        found = self._reached
        for literal in bits(needed):
            found &= self._beside.get(literal, 0)
        return None if needed & ~found else found

    def _needs(self, condition: GroundCondition) -> int:
        return condition.true | condition.false << self._atoms

    def _makes(self, change: GroundChange) -> int:
        return change.add | (change.delete & ~change.add) << self._atoms

    def _denied(self, literals: int) -> int:
        """The opposites of literals."""
        return literals >> self._atoms | (literals & self._every_atom) << self._atoms
