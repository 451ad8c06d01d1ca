"""The order in which CPython iterates a set of small integers.

The reference keeps the ends of edges in Python sets and takes "the first" of them, so the layout of a hash
table decides some of its verdicts. That layout is a fixed function of the insertions (the hash of a small
integer is the integer itself); it is written out here so that verdicts do not depend on the interpreter.
"""

from __future__ import annotations

from collections.abc import Iterable

_FIRST_SIZE = 8
_LINEAR_PROBES = 9
_PERTURB_SHIFT = 5


class _Table:
    """An open-addressing table of non-negative integers, laid out as CPython does it."""

    def __init__(self) -> None:
        self.slots: list[int | None] = [None] * _FIRST_SIZE
        self.used = 0
        self.has_holes = False

    def add(self, value: int) -> None:
        """Insert one value; grow when three fifths are full."""
        slot = self._find(value)
        if self.slots[slot] is not None:
            return
        self.slots[slot] = value
        self.used += 1
        if self.used * 5 >= (len(self.slots) - 1) * 3:
            self._resize(self.used * 4)

    def update(self, other: _Table) -> None:
        """Insert all values of another table, in its order; grow beforehand where they might not fit."""
        if (self.used + other.used) * 5 >= (len(self.slots) - 1) * 3:
            self._resize((self.used + other.used) * 2)
        if not self.used and len(self.slots) == len(other.slots) and not other.has_holes:
            self.slots, self.used = list(other.slots), other.used
            return
        for value in other.values():
            self.add(value)

    def without(self, other: _Table) -> _Table:
        """The difference: a copy with holes if this is much the larger table, else built anew."""
        removed = set(other.values())
        result = _Table()
        if self.used >> 2 > other.used:
            result.update(self)
            result.slots = [None if value in removed else value for value in result.slots]
            holes = result.used - len(result.values())
            result.used, result.has_holes = len(result.values()), holes > 0
            if holes > (len(result.slots) - 1) // 4:
                result._resize(result.used * 4)
            return result
        for value in self.values():
            if value not in removed:
                result.add(value)
        return result

    def values(self) -> list[int]:
        """All values in the order of their slots."""
        return [value for value in self.slots if value is not None]

    def _find(self, value: int) -> int:
        """The slot that holds the value, or the free slot where it goes."""
        mask = len(self.slots) - 1
        perturb, slot = value, value & mask
        while True:
            probes = _LINEAR_PROBES if slot + _LINEAR_PROBES <= mask else 0
            for candidate in range(slot, slot + probes + 1):
                if self.slots[candidate] is None or self.slots[candidate] == value:
                    return candidate
            perturb >>= _PERTURB_SHIFT
            slot = (slot * 5 + 1 + perturb) & mask

    def _resize(self, above: int) -> None:
        """Lay all values out again in the smallest table whose size is more than ``above``."""
        size = _FIRST_SIZE
        while size <= above:
            size *= 2
        values = self.values()
        self.slots = [None] * size
        self.has_holes = False
        for value in values:
            self.slots[self._find(value)] = value


def slot_order(values: Iterable[int]) -> list[int]:
    """The values in the order of a set into which they were put one by one."""
    return _table(values).values()


def _table(values: Iterable[int]) -> _Table:
    table = _Table()
    for value in values:
        table.add(value)
    return table


def union_order(values: Iterable[int], more: Iterable[int]) -> list[int]:
    """The values in the order of the union of a set with the difference of a second set and it."""
    first, second = _table(values), _table(more)
    union = _Table()
    union.update(first)
    union.update(second.without(first))
    return union.values()
