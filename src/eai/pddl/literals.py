"""Ground conditions as masks over literals, so that many are looked at as one.

With n atoms, bit i of a set of literals says that atom i may be true, and bit n + i that it may be false. A
state has one of the two for each atom; in a relaxed state (`relaxation`) both may be so. Beyond them each
choice that conditions leave is a literal of its own, equal choices the same one: it is there where one of its
options is. So any condition is a mask of the literals that it needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from eai.pddl.grounding import GroundCondition
from eai.planning.effort import Effort


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
        """What is so in a state."""
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
        """What is needed where these literals are, with the first option that is there of each choice."""
        if needed >> 3 * self.atoms:
            for literal, options, _, _ in reversed(self._choices.values()):
                if needed & literal:
                    needed ^= literal
                    needed |= next(option for option in options if not option & ~literals)
        return needed

    def mentioned(self, needed: int) -> int:
        """What is needed, whatever is chosen: the literals, the choices and all of their options."""
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
