"""Tables as Markdown, for reading as text and on the web."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from eai.base.files import escape_unprintable
from eai.results.table import Cell, Column, Estimate, Label, Table, short_number, superscript

NOTHING = "–"
"""The mark where there is no number."""


def table_markdown(table: Table) -> str:
    """A table with its footnotes; a row with intervals is followed by one of them, which is set small."""
    columns = table.full_columns
    lines = [line for row in table.rows for line in _row(columns, row)]
    notes = [f"{superscript((number,))} {text}  " for number, text in enumerate(table.notes, 1)]
    return "\n".join([*_grid(columns, lines), *([""] if notes else []), *notes]) + "\n"


def rows_markdown(columns: Sequence[Column], rows: Iterable[Sequence[Cell]]) -> Iterator[str]:
    """The lines of a table, a line a row: a number stands with what it is made of and its interval."""
    return _grid(columns, [[_in_line(cell) for cell in row] for row in rows])


def grid(header: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """The lines of a table of texts; the first two columns are text, the others numbers."""
    return _grid([Column(name, is_number=i >= 2) for i, name in enumerate(header)], rows)


def escape_markdown(text: str) -> str:
    """Text from outside, such that it is only text in a cell or a paragraph."""
    text = escape_unprintable(text)
    for character in "\\`*_[]<>|#":
        text = text.replace(character, f"\\{character}")
    return " ".join(text.split())


def _grid(columns: Sequence[Column], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    headings = [column.heading_without_group or column.heading or column.name for column in columns]
    marks = [superscript(column.notes) for column in columns]
    yield _line([f"{heading}{mark}" for heading, mark in zip(headings, marks, strict=True)])
    yield _line(["--:" if column.is_number else "---" for column in columns])
    yield from map(_line, rows)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _row(columns: Sequence[Column], row: Sequence[Cell]) -> Iterator[list[str]]:
    """The cells, and below them the intervals, which their name announces."""
    yield [_cell(column, cell) for column, cell in zip(columns, row, strict=True)]
    if any(isinstance(cell, Estimate) and cell.low is not None for cell in row):
        name = next(i for i, cell in enumerate(row) if isinstance(cell, Label))
        yield ["*95 %*" if i == name else _interval(cell) for i, cell in enumerate(row)]


def _cell(column: Column, cell: Cell) -> str:
    if not isinstance(cell, Estimate):
        return _in_line(cell)
    number = cell.format_number(column, NOTHING)
    return (f"**{number}**" if cell.best else number) + superscript(cell.notes)


def _interval(cell: Cell) -> str:
    if not isinstance(cell, Estimate) or cell.low is None:
        return ""
    return f"{cell.low:.1f}–{cell.high:.1f}"


def _in_line(cell: Cell) -> str:
    match cell:
        case None:
            return ""
        case bool():
            return "yes" if cell else "no"
        case float():
            return short_number(cell)
        case Label(text=text, target=target, origin=origin):
            name = escape_markdown(text) if target is None else f"[{escape_markdown(text)}]({target})"
            return f"{name}{f' *({origin})*' if origin else ''}{superscript(cell.notes)}"
        case _:
            return escape_unprintable(str(cell)).replace("|", "\\|").replace("\n", " ")
