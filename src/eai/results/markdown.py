"""Writes tables as Markdown, for readers of text files and of web pages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from eai.base.files import escape_unprintable
from eai.results.table import Cell, Column, Estimate, Table, TextCell, format_short_number, format_superscript

NO_NUMBER_MARK = "–"
"""Mark that replaces a missing number."""


def format_markdown_table(table: Table) -> str:
    """Return a table and its footnotes as Markdown.

    Intervals of a row are printed in a row of their own, below it.
    """
    columns = table.columns_with_headings
    lines = [line for row in table.rows for line in _format_row_and_its_intervals(columns, row)]
    notes = [f"{format_superscript((number,))} {text}  " for number, text in enumerate(table.notes, 1)]
    return "\n".join([*_format_grid(columns, lines), *([""] if notes else []), *notes]) + "\n"


def format_markdown_rows(columns: Sequence[Column], rows: Iterable[Sequence[Cell]]) -> Iterator[str]:
    """Yield the Markdown lines of a table: the heading, the line below it, and a line for each row.

    Each rate is followed by its numerator and denominator, and by its interval.
    """
    return _format_grid(columns, [[_format_plain_cell(cell) for cell in row] for row in rows])


def format_text_grid(header: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a Markdown table whose cells are texts.

    All columns from the third on hold numbers, aligned right.
    """
    return _format_grid([Column(name, is_number=i >= 2) for i, name in enumerate(header)], rows)


def escape_markdown(text: str) -> str:
    """Return text from models or data sets, escaped to be plain text in a Markdown cell or paragraph."""
    text = escape_unprintable(text)
    for character in "\\`*_[]<>|#":
        text = text.replace(character, f"\\{character}")
    return " ".join(text.split())


def _format_grid(columns: Sequence[Column], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    headings = [column.heading_without_group or column.heading or column.name for column in columns]
    marks = [format_superscript(column.notes) for column in columns]
    yield _format_line([f"{heading}{mark}" for heading, mark in zip(headings, marks, strict=True)])
    yield _format_line(["--:" if column.is_number else "---" for column in columns])
    yield from map(_format_line, rows)


def _format_line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _format_row_and_its_intervals(columns: Sequence[Column], row: Sequence[Cell]) -> Iterator[list[str]]:
    """Yield the cells of a row as one list and, if the row has intervals, its intervals as a second list."""
    yield [_format_cell(column, cell) for column, cell in zip(columns, row, strict=True)]
    if any(isinstance(cell, Estimate) and cell.low is not None for cell in row):
        name = next(i for i, cell in enumerate(row) if isinstance(cell, TextCell))
        yield ["*95 %*" if i == name else _format_interval(cell) for i, cell in enumerate(row)]


def _format_cell(column: Column, cell: Cell) -> str:
    if not isinstance(cell, Estimate):
        return _format_plain_cell(cell)
    number = cell.format_number(column, NO_NUMBER_MARK)
    return (f"**{number}**" if cell.best else number) + format_superscript(cell.notes)


def _format_interval(cell: Cell) -> str:
    if not isinstance(cell, Estimate) or cell.low is None:
        return ""
    return f"{cell.low:.1f}–{cell.high:.1f}"


def _format_plain_cell(cell: Cell) -> str:
    match cell:
        case None:
            return ""
        case bool():
            return "yes" if cell else "no"
        case float():
            return format_short_number(cell)
        case TextCell(text=text, target=target, origin=origin):
            name = escape_markdown(text) if target is None else f"[{escape_markdown(text)}]({target})"
            return f"{name}{f' *({origin})*' if origin else ''}{format_superscript(cell.notes)}"
        case _:
            return escape_unprintable(str(cell)).replace("|", "\\|").replace("\n", " ")
