"""Tables on a terminal: as many columns side by side as fit, and no number is ever cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table as Grid
from rich.text import Text

from eai.results.table import Cell, Column, Estimate, Label, Table, superscript

_Shown: TypeAlias = tuple[Column, Sequence[Text]]
"""A column with its cells as they are printed."""

_NAMES = 0.4
"""The share of the width that names may take before they are folded."""


def print_table(console: Console, table: Table, *, wide: bool = False) -> None:
    """Print a table under its title.

    The columns up to the first texts name the rows; what does not fit beside them follows below, with the
    names again. Other texts are folded into what the last part leaves.

    Args:
        console: where to.
        table: the table.
        wide: all side by side, however wide.
    """
    console.print(Text(table.title, style="bold"), soft_wrap=True)
    if not table.rows:
        console.print("no rows\n", highlight=False)
        return
    limit = None if wide else int(console.width * _NAMES)
    columns = [
        (column, [_cell(column, row[place]) for row in table.rows])
        for place, column in enumerate(table.full_columns)
    ]
    for part in [columns] if wide else _parts(console, columns, limit):
        grid = _grid(part, limit)
        room = max(console.width, _width(console, grid)) if wide else console.width
        type(console)(file=console.file, width=room, markup=False).print(grid, "")


def _parts(console: Console, columns: Sequence[_Shown], limit: int | None) -> Iterator[Sequence[_Shown]]:
    """The columns in groups that fit beside the names, each with one column at least."""
    begin = next(i for i, (column, _) in enumerate(columns) if not column.is_number)
    first = next((i for i in range(begin, len(columns)) if columns[i][0].is_number), begin + 1)
    names, rest = columns[:first], columns[first:]
    beside = taken = _width(console, _grid(names, limit))
    part: list[_Shown] = []
    for shown in (shown for shown in rest if shown[0].is_number):
        width = _width(console, _grid([*names, shown], limit)) - beside
        if part and taken + width > console.width:
            yield [*names, *part]
            part, taken = [], beside
        part.append(shown)
        taken += width
    part += [shown for shown in rest if not shown[0].is_number]
    if part:
        yield [*names, *part]


def _width(console: Console, grid: Grid) -> int:
    """How many characters a table takes where it has room."""
    return Measurement.get(console, console.options.update(max_width=10_000), grid).maximum


def _grid(columns: Sequence[_Shown], limit: int | None) -> Grid:
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


def _cell(column: Column, cell: Cell) -> Text:
    match cell:
        case None:
            return Text("")
        case Estimate(value=value, low=low, high=high, best=best):
            text = Text(cell.format_number(column, "-"), style="bold" if best and value is not None else "")
            if low is not None and high is not None:
                text.append(f"\n±{(high - low) / 2:.1f}", style="dim not bold")
            return text
        case Label(origin=origin, notes=notes):
            style = "bold" if cell.bold else "dim" if cell.dim or origin else ""
            return Text(f"{cell}{superscript(notes)}", style=style)
        case _:
            return Text(str(cell))
