"""Relations over the objects 0..n-1, which are immutable and cheap to copy with changes.

A binary relation is kept as bit masks. A relation of three or more arguments is a set of tuples.

Row ``x`` is the mask of all ``y`` with ``(x, y)`` in the relation. Column ``y`` is the mask of all ``x`` with
``(x, y)`` in the relation. All states of an episode share a base, the relation at the start of the episode.
Each state's relation overrides whole rows and columns (lines) of the base. Household actions move one object
at a time, so a handful of overridden lines describes any state. Removing all pairs of an object, as source
and as target, costs two dictionary entries.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import reduce
from itertools import islice
from operator import or_
from typing import TypeAlias

ObjectMask: TypeAlias = int
"""Bit mask of objects: the bit at an object's index is set if the mask contains the object."""

ALL_OBJECTS: ObjectMask = -1
"""Mask of all objects of any scene."""

_PRIME = (1 << 60) - 93
"""Prime modulus of the hashes of relations. A hash is a sum of powers of 2.

Few powers of 2 have equal remainders modulo this prime, so different relations rarely have equal hashes.
"""


class InitialRelation:
    """A relation as it is at the start of an episode: a bit mask for each row and for each column.

    It never changes. Later relations of the episode store only the rows and columns that differ from it.
    ``sources`` and ``targets`` are the masks of all objects with a nonempty row, and with a nonempty column.
    Both masks are computed if they are not given.
    """

    __slots__ = ("columns", "rows", "sources", "targets")

    def __init__(
        self, rows: Iterable[int], columns: Iterable[int], sources: int = 0, targets: int = 0
    ) -> None:
        self.rows, self.columns = tuple(rows), tuple(columns)
        self.sources = sources or reduce(or_, filter(None, self.columns), 0)
        self.targets = targets or reduce(or_, filter(None, self.rows), 0)

    @classmethod
    def from_pairs(cls, size: int, pairs: Iterable[tuple[int, int]]) -> InitialRelation:
        """Return a relation over ``size`` objects with exactly these pairs, for the start of an episode."""
        rows, columns = [0] * size, [0] * size
        for source, target in pairs:
            rows[source] |= 1 << target
            columns[target] |= 1 << source
        return cls(rows, columns)


class Relation:
    """A binary relation in one state, stored as the rows and columns that differ from a base.

    All states of an episode share the base: the relation at the start of the episode. A relation that belongs
    to a state never changes. The methods that change a relation are for a new `copy`.

    Two relations are equal if they share a base and have the same pairs.

    ``sources`` and ``targets`` are masks. An object outside of ``sources`` is the source of no pair, and an
    object outside of ``targets`` is the target of no pair.
    """

    __slots__ = (
        "_base",
        "_column_keys",
        "_columns",
        "_hash",
        "_row_keys",
        "_rows",
        "sources",
        "targets",
    )

    # Invariant: `_rows[x]` and `_columns[y]` are up to date; if both exist they agree on (x, y).
    # `_row_keys` and `_column_keys` are bit masks of the keys of `_rows` and `_columns`.
    # `_hash` caches the hash, because many states share a relation. It is None until the hash is computed.

    def __init__(self, base: InitialRelation, changed: Relation | None = None) -> None:
        self._base = base
        self._hash: int | None = None
        if changed is None:
            self._rows: dict[int, int] = {}
            self._columns: dict[int, int] = {}
            self._row_keys = self._column_keys = 0
            self.sources, self.targets = base.sources, base.targets
        else:
            self._rows, self._columns = changed._rows.copy(), changed._columns.copy()
            self._row_keys, self._column_keys = changed._row_keys, changed._column_keys
            self.sources, self.targets = changed.sources, changed.targets

    def row(self, source: int) -> ObjectMask:
        """Return the bit mask of all targets of ``source``."""
        if not self.sources >> source & 1:
            return 0
        line = self._rows.get(source)
        if line is not None:
            return line
        line = self._base.rows[source]
        if self._column_keys:
            return _compute_row_from_changed_columns(line, source, self._columns, self._column_keys)
        return line

    def get_initial_targets(self, source: int) -> ObjectMask:
        """Return the targets of ``source`` in this relation at the start of the episode, as a bit mask."""
        return self._base.rows[source]

    def column(self, target: int) -> ObjectMask:
        """Return the bit mask of all sources that are related to ``target``."""
        if not self.targets >> target & 1:
            return 0
        line = self._columns.get(target)
        if line is not None:
            return line
        line = self._base.columns[target]
        if self._row_keys:
            return _compute_row_from_changed_columns(line, target, self._rows, self._row_keys)
        return line

    def has(self, source: int, target: int) -> bool:
        """Whether the pair (source, target) is in the relation."""
        line = self._rows.get(source)
        if line is not None:
            return bool(line >> target & 1)
        line = self._columns.get(target)
        if line is not None:
            return bool(line >> source & 1)
        return bool(self._base.rows[source] >> target & 1)

    def copy(self) -> Relation:
        """Return a copy of the relation.

        The caller may change the copy before it becomes part of a state.
        """
        return Relation(self._base, self)

    def set_row(self, source: int, targets: ObjectMask) -> None:
        """Relate ``source`` to exactly these targets (a bit mask).

        Call this only on a new `copy`, because the relations of states never change.
        """
        bit = 1 << source
        self._hash = None
        self._rows[source] = targets
        self._row_keys |= bit
        self.sources = self.sources | bit if targets else self.sources & ~bit
        self.targets |= targets
        if self._column_keys:
            _write_row_into_changed_columns(self._columns, source, targets)

    def set_column(self, target: int, sources: ObjectMask) -> None:
        """Relate exactly these sources (a bit mask) to ``target``.

        Call this only on a new `copy`, because the relations of states never change.
        """
        bit = 1 << target
        self._hash = None
        self._columns[target] = sources
        self._column_keys |= bit
        self.targets = self.targets | bit if sources else self.targets & ~bit
        self.sources |= sources
        if self._row_keys:
            _write_row_into_changed_columns(self._rows, target, sources)

    def toggle_pair(self, source: int, target: int) -> None:
        """Add a pair to the relation if it is missing, else remove it.

        Call this only on a new `copy`, because the relations of states never change.
        """
        if target in self._columns and source not in self._rows:  # only the pair's column is overridden
            self.set_column(target, self._columns[target] ^ 1 << source)
        else:
            self.set_row(source, self.row(source) ^ 1 << target)

    def pairs(self, among: ObjectMask = ALL_OBJECTS) -> Iterator[tuple[int, int]]:
        """Yield the pairs of objects in a mask as (source, target), ascending."""
        for source in iterate_bits(self.sources & among):
            for target in iterate_bits(self.row(source) & among):
                yield source, target

    def __len__(self) -> int:
        return sum(self.row(source).bit_count() for source in range(len(self._base.rows)))

    def find_sources_with_changed_targets(self, other: Relation) -> list[int]:
        """Return the sources, ascending, whose targets differ between this relation and another relation.

        Both relations must be of the same predicate and the same episode.
        """
        changed = self._row_keys | other._row_keys
        for target in self._columns.keys() | other._columns.keys():
            changed |= self.column(target) ^ other.column(target)
        return [source for source in iterate_bits(changed) if self.row(source) != other.row(source)]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Relation):
            return NotImplemented
        if self._base is not other._base or hash(self) != hash(other):
            return False
        if self._rows == other._rows and self._columns == other._columns:
            return True
        for source in self._rows.keys() | other._rows.keys():
            if self.row(source) != other.row(source):
                return False
        for target in self._columns.keys() | other._columns.keys():
            if self.column(target) != other.column(target):
                return False
        return True

    def __hash__(self) -> int:
        """Return a hash of the pairs that is computed from the changed rows and columns only.

        It is the sum of 2 to the power of x + y over the pairs (x, y), modulo `_PRIME`. The same sum over the
        pairs at the start of the episode is subtracted.
        """
        if self._hash is None:
            base, other_rows = self._base, ~self._row_keys
            total = 0
            for x, line in self._rows.items():
                total += (line - base.rows[x]) << x
            for y, line in self._columns.items():
                total += ((line & other_rows) - (base.columns[y] & other_rows)) << y
            self._hash = total % _PRIME
        return self._hash


class TupleSet:
    """The facts of a predicate of three or more arguments, as tuples. A `TupleSet` never changes."""

    __slots__ = ("_by_others", "members")

    def __init__(self, members: Iterable[tuple[int, ...]] = ()) -> None:
        self.members = frozenset(members)
        self._by_others: dict[int, dict[tuple[int, ...], int]] = {}

    def find_objects_completing_tuple(self, position: int, other_arguments: tuple[int, ...]) -> ObjectMask:
        """Return the mask of the objects that stand at a position in tuples with these other arguments.

        ``other_arguments`` are the arguments at all other positions, in order.
        """
        by_others = self._by_others.get(position)
        if by_others is None:
            by_others = self._by_others[position] = {}
            for member in self.members:
                rest = member[:position] + member[position + 1 :]
                by_others[rest] = by_others.get(rest, 0) | 1 << member[position]
        return by_others.get(other_arguments, 0)

    def __eq__(self, other: object) -> bool:
        return self.members == other.members if isinstance(other, TupleSet) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.members)


def make_mask(indices: Iterable[int]) -> ObjectMask:
    """Return the bit mask in which the bits at these indices are set; an index may be repeated."""
    return sum([1 << index for index in set(indices)])


def iterate_bits(mask: int) -> Iterator[int]:
    """Yield the positions of the set bits of a bit mask, ascending."""
    while mask:
        low = mask & -mask
        yield low.bit_length() - 1
        mask ^= low


def keep_lowest_set_bits(mask: int, count: int) -> int:
    """Return the bit mask of the ``count`` lowest set bits of a mask."""
    return sum([1 << position for position in islice(iterate_bits(mask), count)])


def _compute_row_from_changed_columns(
    initial_row: ObjectMask,
    source: int,
    changed_columns: Mapping[int, ObjectMask],
    changed_column_indices: ObjectMask,
) -> ObjectMask:
    """Return the row of ``source`` in a relation: its initial row, updated from the changed columns.

    A row is the mask of the targets of one source. A column is the mask of the sources of one target.

    To compute a column from changed rows, swap rows and columns in the arguments.
    """
    row = initial_row & ~changed_column_indices
    for target, column in changed_columns.items():
        if column >> source & 1:
            row |= 1 << target
    return row


def _write_row_into_changed_columns(
    changed_columns: dict[int, ObjectMask], source: int, row: ObjectMask
) -> None:
    """Update the changed columns of a relation after ``source`` gets a new row.

    A row is the mask of the targets of one source. A column is the mask of the sources of one target.

    To update changed rows after a target gets a new column, swap rows and columns in the arguments.
    """
    bit = 1 << source
    for target, column in changed_columns.items():
        changed_columns[target] = column | bit if row >> target & 1 else column & ~bit
