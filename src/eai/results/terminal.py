"""Prints tables on a terminal: as many columns side by side as fit, and no number is ever cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from eai.results.table import Cell, Column, Estimate, Table, TextCell, format_superscript

_PrintedColumn: TypeAlias = tuple[Column, Sequence[Text]]
"""A column with its cells as printed texts."""

_NAMES_WIDTH_SHARE = 0.4
"""Maximum share of the terminal's width for the names of rows; longer names are folded."""


def print_table(console: Console, table: Table, *, wide: bool = False) -> None:
    """Print a table under its title.

    The text columns at the left name the rows. Columns that do not fit beside these names follow below, with
    the names repeated. Text in all other columns is wrapped to the space that remains.

    Args:
        console: the terminal.
        table: the table.
        wide: print all columns side by side, even if the table is wider than the terminal.
    """
    console.print(Text(table.title, style="bold"), soft_wrap=True)
    if not table.rows:
        console.print("no rows\n", highlight=False)
        return
    limit = None if wide else int(console.width * _NAMES_WIDTH_SHARE)
    columns = [
        (column, [_format_cell(column, row[index]) for row in table.rows])
        for index, column in enumerate(table.columns_with_headings)
    ]
    for group in [columns] if wide else _split_columns(console, columns, limit):
        grid = _make_grid(group, limit)
        room = max(console.width, _measure_width(console, grid)) if wide else console.width
        type(console)(file=console.file, width=room, markup=False).print(grid, "")


def _split_columns(
    console: Console, columns: Sequence[_PrintedColumn], limit: int | None
) -> Iterator[Sequence[_PrintedColumn]]:
    """Yield groups of columns that fit beside the names of rows, each with at least one column."""
    first_name = next((i for i, (column, _) in enumerate(columns) if not column.is_number), 0)
    name_end = next((i for i in range(first_name, len(columns)) if columns[i][0].is_number), first_name + 1)
    names, rest = columns[:name_end], columns[name_end:]
    names_width = width_taken = _measure_width(console, _make_grid(names, limit))
    group: list[_PrintedColumn] = []
    for column in (column for column in rest if column[0].is_number):
        width = _measure_width(console, _make_grid([*names, column], limit)) - names_width
        if group and width_taken + width > console.width:
            yield [*names, *group]
            group, width_taken = [], names_width
        group.append(column)
        width_taken += width
    group += [column for column in rest if not column[0].is_number]
    if group or not rest:
        yield [*names, *group]


def _measure_width(console: Console, grid: Grid) -> int:
    return Measurement.get(console, console.options.update(max_width=10_000), grid).maximum


def _make_grid(columns: Sequence[_PrintedColumn], limit: int | None) -> Grid:
    grid = Grid(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, collapse_padding=True)
    names = True
    for column, _ in columns:
        heading = Text(column.heading_without_group or column.heading)
        if column.is_number:
            grid.add_column(heading, justify="right", no_wrap=True)
        else:
            grid.add_column(heading, overflow="fold", max_width=limit if names else None)
            names = False
    for row in zip(*(cells for _, cells in columns), strict=True):
        grid.add_row(*row)
    return grid


def _format_cell(column: Column, cell: Cell) -> Text:
    match cell:
        case None:
            return Text("")
        case Estimate(value=value, low=low, high=high, best=best):
            text = Text(cell.format_number(column, "-"), style="bold" if best and value is not None else "")
            if low is not None and high is not None:
                text.append(f"\n±{(high - low) / 2:.1f}", style="dim not bold")
            return text
        case TextCell(origin=origin, notes=notes):
            style = "bold" if cell.bold else "dim" if cell.dim or origin else ""
            return Text(f"{cell}{format_superscript(notes)}", style=style)
        case _:
            return Text(str(cell))
