"""Tables of some models and some columns, for where a whole one has no room."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from eai.errors import InputError, did_you_mean
from eai.report.row import Row
from eai.report.table import Table, with_best_marked
from eai.report.table_specs import ColumnSpec


@dataclass(frozen=True, slots=True)
class Narrow:
    """What of a table is shown.

    Attributes:
        models: the models, by name, or all if empty.
        columns: the columns, by their own heading or that above them, in any case; all if empty.
        intervals: whether intervals stand below the numbers.
    """

    models: Collection[str] = ()
    columns: Collection[str] = ()
    intervals: bool = True

    def tables(self, tables: Sequence[Table], besides: Collection[str] = ()) -> list[Table]:
        """What is shown of tables; one of which nothing is shown is left out.

        Args:
            tables: the tables.
            besides: models that stand elsewhere.

        Raises:
            InputError: there is no such model or column in any of them.
        """
        _check("--models", self.models, {*besides, *(row.model for table in tables for row in table.rows)})
        headings = {heading for table in tables for column in table.columns for heading in _headings(column)}
        _check("--columns", [name.casefold() for name in self.columns], headings)
        return [narrow for table in tables if (narrow := self._table(table)) is not None]

    def _table(self, table: Table) -> Table | None:
        wanted = {name.casefold() for name in self.columns}
        places = [i for i, column in enumerate(table.columns) if not wanted or wanted & _headings(column)]
        rows = [row for row in table.rows if not self.models or row.model in self.models]
        if not places or not rows:
            return None
        columns = tuple(table.columns[i] for i in places)
        rows = [replace(row, cells=tuple(row.cells[i] for i in places)) for row in rows]
        column_notes = [table.column_notes[i] for i in places]
        used = {number for numbers in column_notes for number in numbers}
        used |= {number for row in rows for numbers in _notes(row) for number in numbers}
        new = {number: place for place, number in enumerate(sorted(used), 1)}
        ranks = [row.rank for row in rows]
        renumbered = [
            replace(
                row,
                rank=None if row.rank is None else 1 + sum(r is not None and r < row.rank for r in ranks),
                notes=tuple(new[n] for n in row.notes),
                cells=tuple(replace(cell, notes=tuple(new[n] for n in cell.notes)) for cell in row.cells),
            )
            for row in rows
        ]
        return replace(
            table,
            columns=columns,
            column_notes=tuple(tuple(new[n] for n in numbers) for numbers in column_notes),
            rows=tuple(with_best_marked(columns, renumbered)),
            notes=tuple(table.notes[number - 1] for number in sorted(used)),
        )


def _headings(column: ColumnSpec) -> set[str]:
    return {column.group.casefold(), column.label.casefold()}


def _notes(row: Row) -> list[tuple[int, ...]]:
    return [row.notes, *(cell.notes for cell in row.cells)]


def _check(option: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"{option}: no table has {name!r}{did_you_mean(name, sorted(known))}")
