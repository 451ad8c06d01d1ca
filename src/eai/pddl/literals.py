"""Ground conditions as masks over literals, so that many are looked at as one.

With n atoms, bit i of a set of literals says that atom i may be true, and bit n + i that it may be false. A
state has one of the two for each atom; in a relaxed state (`relaxation`) both may be so. Beyond them each
choice that conditions leave is a literal of its own, equal choices the same one: it is there where one of its
options is. So any condition is a mask of the literals that it needs, and all actions that are possible in a
state are found at once (`Successors`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from eai.pddl.grounding import ALWAYS, GroundAction, GroundCondition
from eai.planning.search import Effort

_SUCCESSOR = 10
"""How many looks it takes to apply an action."""


class _Choice(NamedTuple):
    """A choice: its literal, its options in order, those of one literal as a mask, and the others."""

    literal: int
    options: tuple[int, ...]
    simple: int
    compound: tuple[int, ...]


class Literals:
    """The literals of one problem.

    Args:
        atoms: how many atoms there are.
        looks: how many options may be looked at.

    Attributes:
        atoms: how many atoms there are; literals from 2 to 3 times that number on are left free.
    """

    def __init__(self, atoms: int, looks: Effort) -> None:
        self.atoms = atoms
        self._looks = looks
        self._every_atom = (1 << atoms) - 1
        self._choices: dict[tuple[int, ...], _Choice] = {}
        self._effort = 0

    def needs(self, condition: GroundCondition) -> int:
        """The literals that a condition needs."""
        needed = condition.true | condition.false << self.atoms
        for options in condition.choices:
            needed |= self._choice(tuple([self.needs(option) for option in options])).literal
        return needed

    def _choice(self, options: tuple[int, ...]) -> _Choice:
        choice = self._choices.get(options)
        if choice is None:
            literal = 1 << 3 * self.atoms + len(self._choices)
            compound = tuple([option for option in options if option & option - 1])
            simple = sum({*options}.difference(compound))
            choice = self._choices[options] = _Choice(literal, options, simple, compound)
            self._effort += 1 + len(compound)
        return choice

    def of(self, state: int) -> int:
        """The literals in a state."""
        return self.with_choices(state | (~state & self._every_atom) << self.atoms)

    def with_choices(self, literals: int) -> int:
        """Literals, and the choices with an option among them."""
        self._looks.used += self._effort
        choices = self._choices.values()  # the options of later ones may be earlier ones
        for literal, _, simple, compound in choices:
            if not literals & literal and (
                simple & literals or any(not option & ~literals for option in compound)
            ):
                literals |= literal
        return literals

    def chosen(self, needed: int, literals: int) -> int:
        """The literals needed where some are, with the first option that is there of each choice."""
        if needed >> 3 * self.atoms:
            for literal, options, _, _ in reversed(self._choices.values()):
                if needed & literal:
                    needed ^= literal
                    needed |= next(option for option in options if not option & ~literals)
        return needed

    def mentioned(self, needed: int) -> int:
        """All that may be needed, whatever is chosen: the literals, the choices and all of their options."""
        for literal, options, _, _ in reversed(self._choices.values()):
            if needed & literal:
                for option in options:
                    needed |= option
        return needed


def grouped(masks: Iterable[int]) -> Mapping[int, int]:
    """For each bit of any of the masks, as a mask, the set of the numbers of the masks that have it."""
    numbers: dict[int, list[int]] = {}
    for number, mask in enumerate(masks):
        for bit in bits(mask):
            numbers.setdefault(bit, []).append(number)
    return {bit: _set_of(each) for bit, each in numbers.items()}


def _set_of(numbers: Sequence[int]) -> int:
    """The numbers, which ascend, as a mask."""
    octets = bytearray(numbers[-1] // 8 + 1)
    for number in numbers:
        octets[number >> 3] |= 1 << (number & 7)
    return int.from_bytes(octets, "little")


def bits(mask: int) -> Iterator[int]:
    """The bits of a mask, each as a mask, ascending."""
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit


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


class _Successor(NamedTuple):
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

    def of(self, state: int, literals: int) -> Iterator[_Successor]:
        """The successors of a state, in which these literals are, by the actions in their order."""
        possible = self._everything
        for literal, needing in self._needing.items():
            if not literals & literal:
                possible &= ~needing
        self._looks.used += self._price + _SUCCESSOR * possible.bit_count()
        for action in bits(possible):
            yield _Successor(action, self.after(action.bit_length() - 1, state, literals))

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
