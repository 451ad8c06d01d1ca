"""Writes tables as LaTeX, for the packages booktabs and graphicx."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby

from eai.base.files import escape_unprintable
from eai.results.table import Cell, Column, Estimate, Row, Table, TextCell

_ESCAPES = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "“": "``",
    "”": "''",
    "–": "--",
    **{character: f"\\{character}" for character in "&%$#_{}"},
}

_MAX_LINES_PER_PAGE = 38
"""Maximum number of lines of numbers in a table on one page."""


def format_latex_table(table: Table, *, label: str, intervals: bool = True) -> str:
    """Return a table in LaTeX, split into tables that each fit a page; the last one has the footnotes.

    The caption is the table's definition, which must have no full stop at its end.

    Args:
        table: the table.
        label: LaTeX label of the table, without its prefix ``tab:eai:``.
        intervals: whether 95 % intervals are printed below the numbers.
    """
    parts = list(_split_pages(table.rows, intervals=intervals))
    interval_note = (
        r"; below each run its 95\,\% intervals" if intervals and any(map(_has_interval, table.rows)) else ""
    )
    caption = f"{escape_latex(table.definition)}{interval_note}."
    return "\n".join(
        _format_table_environment(
            replace(table, rows=tuple(rows), notes=table.notes if number == len(parts) else ()),
            caption if number == 1 else f"{caption} (continued)",
            label if number == 1 else f"{label}:{number}",
            intervals=intervals,
        )
        for number, rows in enumerate(parts, 1)
    )


def escape_latex(text: str) -> str:
    """Return text as LaTeX; characters beyond Latin-1 that a plain document cannot set become ``?``."""
    return "".join(_ESCAPES.get(c) or (c if " " <= c < "\u0100" else "?") for c in escape_unprintable(text))


def _split_pages(rows: Sequence[Row], *, intervals: bool) -> Iterator[list[Row]]:
    page: list[Row] = []
    lines = 0
    for row in rows:
        height = 2 if intervals and _has_interval(row) else 1
        if page and lines + height > _MAX_LINES_PER_PAGE:
            yield page
            page, lines = [], 0
        page.append(row)
        lines += height
    yield page


def _format_table_environment(table: Table, caption: str, label: str, *, intervals: bool) -> str:
    columns = table.columns_with_headings
    parts = [
        r"\begin{table}[htbp]",
        r"\centering",
        rf"\caption{{{caption}}}",
        rf"\label{{tab:eai:{label}}}",
        r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{{''.join('r' if column.is_number else 'l' for column in columns)}}}",
        r"\toprule",
        *_format_heading(columns),
        r"\midrule",
        *(line for row in table.rows for line in _format_row(columns, row, intervals=intervals)),
        r"\bottomrule",
        r"\end{tabular}}",
        *_format_footnotes(table.notes),
        r"\end{table}",
    ]
    return "\n".join(parts) + "\n"


def _format_heading(columns: Sequence[Column]) -> Iterator[str]:
    """Yield the LaTeX lines of a table's heading: groups of columns above rules, then column headings."""
    groups, rules, start = [], [], 1
    for name, columns_of_group in groupby(column.group for column in columns):
        width = len(list(columns_of_group))
        if name:
            groups.append(rf"\multicolumn{{{width}}}{{c}}{{{escape_latex(name)}}}")
            rules.append(rf"\cmidrule(lr){{{start}-{start + width - 1}}}")
        else:
            groups += [""] * width
        start += width
    if rules:
        yield _format_line(groups)
        yield "".join(rules)
    yield _format_line(
        [escape_latex(column.heading) + _format_footnote_marks(column.notes) for column in columns]
    )


def _format_row(columns: Sequence[Column], row: Sequence[Cell], *, intervals: bool) -> Iterator[str]:
    yield _format_line([_format_cell(column, cell) for column, cell in zip(columns, row, strict=True)])
    if intervals and _has_interval(row):
        intervals_below = (
            rf"{{\scriptsize {_format_interval(cell)}}}" if isinstance(cell, Estimate) else "" for cell in row
        )
        yield _format_line(list(intervals_below))


def _has_interval(row: Sequence[Cell]) -> bool:
    return any(isinstance(cell, Estimate) and cell.low is not None for cell in row)


def _format_cell(column: Column, cell: Cell) -> str:
    match cell:
        case None:
            return ""
        case Estimate():
            number = cell.format_number(column, "--")
            return (rf"\textbf{{{number}}}" if cell.best else number) + _format_footnote_marks(cell.notes)
        case TextCell(text=text, origin=origin, notes=notes):
            name = escape_latex(text)
            return (rf"\emph{{{name}}} ({origin})" if origin else name) + _format_footnote_marks(notes)
        case _:
            return escape_latex(str(cell))


def _format_interval(cell: Estimate) -> str:
    return "" if cell.low is None else f"{cell.low:.1f}--{cell.high:.1f}"


def _format_footnote_marks(numbers: Sequence[int]) -> str:
    return rf"\textsuperscript{{{','.join(map(str, numbers))}}}" if numbers else ""


def _format_footnotes(texts: Sequence[str]) -> Iterator[str]:
    if texts:
        yield r"\par\smallskip\begin{minipage}{\linewidth}\footnotesize"
        for number, text in enumerate(texts, 1):
            yield rf"{_format_footnote_marks((number,))} {escape_latex(text)}\par"
        yield r"\end{minipage}"


def _format_line(cells: Sequence[str]) -> str:
    return rf"{' & '.join(cells)} \\"
