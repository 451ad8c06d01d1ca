"""Landmarks of a repair: sets of actions, of each of which every repair of a plan inserts one.

What the steps of a plan do not bring about, in whatever order, takes an action more: one that makes a change
that a goal needs, or that makes what a step needs first which would make it. Such a cut through all ways to a
goal is a disjunctive landmark. Cuts with no action in common are so many insertions, as in the heuristic
LM-cut (Helmert and Domshlak 2009). They are found by backchaining (Hoffmann, Porteous and Sebastia 2004):
where an action is in another cut already, what it needs is cut instead.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from eai.logic.formula import Formula
from eai.planning.effect_schema import Change
from eai.planning.flips import Changes, Flips
from eai.world.condition import Scope
from eai.world.execution import Action
from eai.world.state import State

Cut: TypeAlias = frozenset[Action]
"""Actions of which one is inserted."""

_MOST = 1_000
"""So many conditions are looked at; then no more landmarks are found."""

_DEEPEST = 40
"""So many changes are followed that need one another."""


def landmarks(
    flips: Flips, initial: State, steps: Sequence[Action], wanted: Sequence[Changes], taking: Sequence[Cut]
) -> list[Cut]:
    """Landmarks of the repairs of a plan, no two with an action in common.

    Args:
        flips: says which changes conditions need, and which actions make them.
        initial: where plans begin.
        steps: the steps that a repair may keep.
        wanted: for each goal that does not hold at the start the changes one of which it needs.
        taking: for each action goal that no step can be, the actions that can.
    """
    cuts = _Cuts(flips, initial, steps)
    left = [*wanted]
    while left or taking:
        sized = sorted((len(cuts.through(changes) or ()), i) for i, changes in enumerate(left))
        left = [left[i] for size, i in sized if size and cuts.take(cuts.through(left[i]))]
        for each in taking:
            cuts.take(each)
        taking = ()
    return cuts.taken


class _Cuts:
    """Cuts through the ways to changes.

    Args:
        flips: says which changes conditions need, and which actions make them.
        initial: where plans begin.
        steps: the steps that a repair may keep.

    Attributes:
        taken: the cuts that are landmarks, no two with an action in common.
    """

    def __init__(self, flips: Flips, initial: State, steps: Sequence[Action]) -> None:
        self.taken: list[Cut] = []
        self._flips = flips
        self._initial = initial
        self._steps = tuple(dict.fromkeys(steps))
        self._used: set[Action] = set()
        self._open: set[Change] = set()
        self._depth = self._looks = 0

    def take(self, cut: Cut | None) -> bool:
        """Whether a cut has actions, and none in common with those that are taken; then it is one of them."""
        if not cut or not self._used.isdisjoint(cut):
            return False
        self.taken.append(cut)
        self._used |= cut
        return True

    def through(self, changes: Changes) -> Cut | None:
        """A cut through the ways to some changes by actions of no cut that is taken, if it is found.

        A change that comes first is not made by what needs it before: it is cut once on each way.
        """
        self._looks += 1
        if self._looks > _MOST or self._depth >= _DEEPEST:
            return None
        fresh = sorted(changes - self._open, key=repr)
        self._open.update(fresh)
        self._depth += 1
        cut = _united(self._stopping(change) for change in fresh)
        self._depth -= 1
        self._open.difference_update(fresh)
        return cut

    def _stopping(self, change: Change) -> Cut | None:
        """A cut through the ways to one change: by steps of the plan, which are there, and by actions."""
        steps = [step for step in self._steps if self._flips.may_make(step, change)]
        actions = self._flips.making(change)
        known = [*steps, *[action for action in actions if action in self._used]]
        before = _united(self._before(action, change) for action in known)
        return None if before is None else before | {a for a in actions if a not in self._used}

    def _before(self, action: Action, change: Change) -> Cut | None:
        """A cut through the ways to what an action needs before it makes a change, by whichever effect."""
        return _united(self._needed(conditions) for conditions in self._flips.ways(action, change))

    def _needed(self, conditions: Sequence[tuple[Formula, Scope]]) -> Cut | None:
        """The smallest cut through the ways to one of some conditions that fail at the start."""
        failing = [(c, scope) for c, scope in conditions if not self._flips.holds(c, scope, self._initial)]
        cuts = [self.through(self._flips.of(*each, self._initial, truth=True)) for each in failing]
        return min((cut for cut in cuts if cut is not None), key=len, default=None)


def _united(cuts: Iterable[Cut | None]) -> Cut | None:
    """All actions of some cuts; None if one of them is not found."""
    found: set[Action] = set()
    for cut in cuts:
        if cut is None:
            return None
        found |= cut
    return frozenset(found)
