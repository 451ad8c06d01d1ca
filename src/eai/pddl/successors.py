"""What ground actions do in a state: all of those that are possible there are found at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from eai.pddl.grounding import ALWAYS, GroundAction
from eai.pddl.literals import Literals, bits, grouped
from eai.planning.effort import Effort

_SUCCESSOR = 10
"""How many looks it takes to apply an action."""


class _Conditional(NamedTuple):
    """A conditional effect: the literals that it needs, and the atoms that it adds and deletes."""

    needs: int
    add: int
    delete: int


class _Effect(NamedTuple):
    """The atoms that an action adds and deletes in any case, and its conditional effects."""

    add: int
    delete: int
    conditional: Sequence[_Conditional]


class Successor(NamedTuple):
    """The set of the action, which has its number's bit alone, and the state after it."""

    action: int
    state: int


class Successors:
    """The successors of states by some actions.

    Args:
        actions: the ground actions, numbered in order.
        literals: what their conditions are about.
        looks: how many literals, conditions and effects may be looked at.
    """

    def __init__(self, actions: Sequence[GroundAction], literals: Literals, looks: Effort) -> None:
        self._looks = looks
        self._everything = (1 << len(actions)) - 1
        self._needing = grouped([literals.needs(action.precondition) for action in actions])
        self._effects = [_effect(action, literals) for action in actions]
        self._price = looks_for(len(actions)) * len(self._needing)

    def of(self, state: int, literals: int) -> Iterator[Successor]:
        """The successors of a state, in which these literals are, by the actions in their order."""
        possible = self._everything
        for literal, needing in self._needing.items():
            if not literals & literal:
                possible &= ~needing
        self._looks.used += self._price + _SUCCESSOR * possible.bit_count()
        for action in bits(possible):
            yield Successor(action, self.after(action.bit_length() - 1, state, literals))

    def after(self, number: int, state: int, literals: int) -> int:
        """The state after the action of this number, whether or not it is possible."""
        add, delete, conditional = self._effects[number]
        for needs, also_add, also_delete in conditional:
            if not needs & ~literals:
                add |= also_add
                delete |= also_delete
        return state & ~delete | add  # what is both deleted and added is true


def looks_for(conditions: int) -> int:
    """How many looks it takes to see which of so many conditions need a literal."""
    return 1 + conditions // 2_000


def _effect(action: GroundAction, literals: Literals) -> _Effect:
    add = delete = 0
    conditional = []
    for change in action.changes:
        if change.condition == ALWAYS:
            add |= change.add
            delete |= change.delete
        else:
            conditional.append(_Conditional(literals.needs(change.condition), change.add, change.delete))
    return _Effect(add, delete, conditional)
