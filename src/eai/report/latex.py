"""Tables as LaTeX, with the package booktabs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from eai.data.files import printable
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
    continued, part = (" (continued)", f":{number}") if number > 1 else ("", "")
    return _floating(
        f"{_caption(table, intervals=intervals)}{continued}",
        f"{table.name}:{_slug(table.domain)}:{_slug(table.protocol.value)}{part}",
        f"rlr{'r' * len(table.columns)}",
        _heading(table),
        (line for row in rows for line in _row(row, intervals=intervals)),
        table.notes if last else (),
    )


def grouped_latex(
    caption: str, label: str, groups: Sequence[str], header: Sequence[str], rows: Iterable[Sequence[str]]
) -> str:
    """A table environment of plain cells: a column of names, and groups of columns of numbers.

    Args:
        caption: what stands above it.
        label: what it is referred to by, after ``tab:eai:``.
        groups: what stands over the groups, all of which have the same number of columns.
        header: what stands over each column.
        rows: the cells.
    """
    width = (len(header) - 1) // len(groups)
    over = [rf"\multicolumn{{{width}}}{{c}}{{{escaped(group)}}}" for group in groups]
    starts = range(2, len(header) + 1, width)
    rules = "".join([rf"\cmidrule(lr){{{start}-{start + width - 1}}}" for start in starts])
    heading = [_line(["", *over]), rules, _line(list(map(escaped, header)))]
    lines = (_line(list(map(escaped, row))) for row in rows)
    return _floating(escaped(caption), label, f"l{'r' * (len(header) - 1)}", heading, lines, ())


def _floating(
    caption: str, label: str, columns: str, heading: Iterable[str], lines: Iterable[str], notes: Sequence[str]
) -> str:
    """A table environment, no wider than a page."""
    parts = [
        r"\begin{table}[htbp]",
        r"\centering",
        rf"\caption{{{caption}}}",
        rf"\label{{tab:eai:{label}}}",
        r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{{columns}}}",
        r"\toprule",
        *heading,
        r"\midrule",
        *lines,
        r"\bottomrule",
        r"\end{tabular}}",
        *_notes(notes),
        r"\end{table}",
    ]
    return "\n".join(parts) + "\n"


def _caption(table: Table, *, intervals: bool) -> str:
    """The protocol and the intervals are those of runs, so a table of the paper's rows alone has none."""
    title = escaped(f"{table.title}, {domain_title(table.domain)}")
    if all(row.source is RowSource.PAPER for row in table.rows):
        return f"{title}. Percent."
    below = r"; below each run its 95\,\% intervals" if intervals else ""
    return f"{title}, protocol {escaped(table.protocol.value)}. Percent{below}."


def escaped(text: str) -> str:
    """Text as LaTeX; characters beyond Latin-1 that a plain document cannot set become ``?``."""
    return "".join(_ESCAPES.get(c) or (c if " " <= c < "\u0100" else "?") for c in printable(text))


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
