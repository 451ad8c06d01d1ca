"""Tables as LaTeX, with the package booktabs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from eai.report.row import Cell, Row, RowSource
from eai.report.table import Table
from eai.report.table_specs import domain_title

PREAMBLE = r"""\documentclass{article}
\usepackage[T1]{fontenc}
\usepackage[utf8]{inputenc}
\usepackage{booktabs}
\usepackage{graphicx}
\usepackage[landscape,margin=1.5cm]{geometry}
\begin{document}
"""
ENDING = "\\end{document}\n"

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


_LINES = 38
"""How many lines of numbers a page has room for in one table."""


def table_latex(table: Table, *, intervals: bool = True) -> str:
    """Table environments, none wider or longer than a page, the last with the footnotes.

    Needs the packages booktabs and graphicx.

    Args:
        table: the table.
        intervals: whether 95 % intervals stand below the numbers.
    """
    parts = list(_parts(table.rows, _LINES, intervals=intervals))
    return "\n".join(
        _environment(table, rows, number, last=number == len(parts), intervals=intervals)
        for number, rows in enumerate(parts, 1)
    )


def _parts(rows: Sequence[Row], most: int, *, intervals: bool) -> Iterator[list[Row]]:
    """The rows by page."""
    part: list[Row] = []
    lines = 0
    for row in rows:
        height = 2 if intervals and _has_interval(row) else 1
        if part and lines + height > most:
            yield part
            part, lines = [], 0
        part.append(row)
        lines += height
    yield part


def _environment(table: Table, rows: Sequence[Row], number: int, *, last: bool, intervals: bool) -> str:
    """One of the environments of a table."""
    place = f"tab:eai:{table.name}:{_slug(table.domain)}:{_slug(table.protocol.value)}"
    lines = [
        r"\begin{table}[htbp]",
        r"\centering",
        rf"\caption{{{_caption(table, intervals=intervals)}{' (continued)' if number > 1 else ''}}}",
        rf"\label{{{place}{f':{number}' if number > 1 else ''}}}",
        r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{rlr{'r' * len(table.columns)}}}",
        r"\toprule",
        *_heading(table),
        r"\midrule",
        *(line for row in rows for line in _row(row, intervals=intervals)),
        r"\bottomrule",
        r"\end{tabular}}",
        *(_notes(table.notes) if last else ()),
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _caption(table: Table, *, intervals: bool) -> str:
    """The protocol and the intervals are those of runs, so a table of the paper's rows alone has none."""
    title = escaped(f"{table.title}, {domain_title(table.domain)}")
    if all(row.source is RowSource.PAPER for row in table.rows):
        return f"{title}. Percent."
    below = r"; below each run its 95\,\% intervals" if intervals else ""
    return f"{title}, protocol {escaped(table.protocol.value)}. Percent{below}."


def escaped(text: str) -> str:
    """Text as LaTeX; characters beyond Latin-1 that a plain document cannot set become ``?``."""
    return "".join(_ESCAPES.get(c) or (c if " " <= c < "\u0100" else "?") for c in text)


def _slug(text: str) -> str:
    return "".join(c if c.isascii() and c.isalnum() else "-" for c in text)


def _heading(table: Table) -> Iterator[str]:
    """Two lines: groups, each over a rule of its own, and labels."""
    groups, rules, start = [], [], 4
    for name, columns in groupby(column.group for column in table.columns):
        width = len(list(columns))
        groups.append(rf"\multicolumn{{{width}}}{{c}}{{{escaped(name)}}}")
        rules.append(rf"\cmidrule(lr){{{start}-{start + width - 1}}}")
        start += width
    yield _line(["", "", "", *groups])
    yield "".join(rules)
    labels = [
        escaped(column.label) + _marks(notes)
        for column, notes in zip(table.columns, table.column_notes, strict=True)
    ]
    yield _line([r"\#", "Model", "Answered", *labels])


def _row(row: Row, *, intervals: bool) -> Iterator[str]:
    name = escaped(row.model)
    rank = "" if row.rank is None else str(row.rank)
    if row.source is not RowSource.RUN:
        name = rf"\emph{{{name}}} ({row.source.value})"
    yield _line([rank, name + _marks(row.notes), row.answered or "--", *map(_number, row.cells)])
    if intervals and _has_interval(row):
        yield _line(["", "", "", *(rf"{{\scriptsize {_interval(cell)}}}" for cell in row.cells)])


def _has_interval(row: Row) -> bool:
    return any(cell.interval for cell in row.cells)


def _number(cell: Cell) -> str:
    if cell.percent is None:
        return "--"
    number = f"{cell.percent:.1f}"
    return (rf"\textbf{{{number}}}" if cell.best else number) + _marks(cell.notes)


def _interval(cell: Cell) -> str:
    return "" if cell.interval is None else f"{cell.interval.low:.1f}--{cell.interval.high:.1f}"


def _marks(numbers: Sequence[int]) -> str:
    return rf"\textsuperscript{{{','.join(map(str, numbers))}}}" if numbers else ""


def _notes(texts: Sequence[str]) -> Iterator[str]:
    if texts:
        yield r"\par\smallskip\begin{minipage}{\linewidth}\footnotesize"
        for number, text in enumerate(texts, 1):
            yield rf"{_marks((number,))} {escaped(text)}\par"
        yield r"\end{minipage}"


def _line(cells: Sequence[str]) -> str:
    return rf"{' & '.join(cells)} \\"
