"""Tables as Markdown, for reading as text and on the web."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from eai.data.files import printable
from eai.report.row import Cell, Row, RowSource
from eai.report.table import Table

_SUPERSCRIPTS = str.maketrans("0123456789,", "⁰¹²³⁴⁵⁶⁷⁸⁹˒")


def table_markdown(table: Table) -> str:
    """A table with its footnotes; a run's row is followed by one with its 95 % intervals."""
    groups = [column.group for column in table.columns]
    labels = [
        _heading(column.group, column.label, groups) + superscript(notes)
        for column, notes in zip(table.columns, table.column_notes, strict=True)
    ]
    rows = [line for row in table.rows for line in _row(row)]
    lines = grid(["#", "model", "answered", *labels], rows)
    notes = [f"{superscript((number,))} {text}  " for number, text in enumerate(table.notes, 1)]
    return "\n".join([*lines, *([""] if notes else []), *notes]) + "\n"


def grid(header: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """The lines of a table; the first two columns are text, the others numbers."""
    yield _line(header)
    yield _line(["---" if i < 2 else "--:" for i in range(len(header))])
    yield from map(_line, rows)


def escaped(text: str) -> str:
    """Text from outside, such that it is only text in a cell or a paragraph."""
    text = printable(text)
    for character in "\\`*_[]<>|#":
        text = text.replace(character, f"\\{character}")
    return " ".join(text.split())


def superscript(numbers: Sequence[int]) -> str:
    """The marks of footnotes."""
    return ",".join(map(str, numbers)).translate(_SUPERSCRIPTS)


def _heading(group: str, label: str, groups: Sequence[str]) -> str:
    """A column's heading, with its group's name only where labels alone would not do."""
    ambiguous = len(set(groups)) > 1 and label in ("P", "R", "F1", "Task", "Execution", "Planner")
    return f"{group}: {label}" if ambiguous or label in ("State", "Relation", "Action", "Total") else label


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _row(row: Row) -> Iterator[list[str]]:
    rank = "" if row.rank is None else str(row.rank)
    origin = "" if row.source is RowSource.RUN else f" *({row.source.value})*"
    name = f"{escaped(row.model)}{origin}{superscript(row.notes)}"
    yield [rank, name, row.answered or "–", *map(_number, row.cells)]
    if any(cell.interval for cell in row.cells):
        yield ["", "*95 %*", "", *map(_interval, row.cells)]


def _number(cell: Cell) -> str:
    if cell.percent is None:
        return "–"
    number = f"{cell.percent:.1f}"
    return (f"**{number}**" if cell.best else number) + superscript(cell.notes)


def _interval(cell: Cell) -> str:
    return "" if cell.interval is None else f"{cell.interval.low:.1f}–{cell.interval.high:.1f}"
