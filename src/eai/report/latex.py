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


def table_latex(table: Table) -> str:
    """A table environment, no wider than the page, with footnotes below it.

    Needs the packages booktabs and graphicx.
    """
    lines = [
        r"\begin{table}[htbp]",
        r"\centering",
        rf"\caption{{{_caption(table)}}}",
        rf"\label{{tab:eai:{table.name}:{_slug(table.domain)}:{_slug(table.protocol.value)}}}",
        r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
        rf"\begin{{tabular}}{{rlr{'r' * len(table.columns)}}}",
        r"\toprule",
        *_heading(table),
        r"\midrule",
        *(line for row in table.rows for line in _row(row)),
        r"\bottomrule",
        r"\end{tabular}}",
        *_notes(table.notes),
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _caption(table: Table) -> str:
    """The protocol and the intervals are those of runs, so a table of the paper's rows alone has none."""
    title = escaped(f"{table.title}, {domain_title(table.domain)}")
    if all(row.source is RowSource.PAPER for row in table.rows):
        return f"{title}. Percent."
    return (
        rf"{title}, protocol {escaped(table.protocol.value)}. Percent; below each run its 95\,\% intervals."
    )


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


def _row(row: Row) -> Iterator[str]:
    name = escaped(row.model)
    rank = "" if row.rank is None else str(row.rank)
    if row.source is not RowSource.RUN:
        name = rf"\emph{{{name}}} ({row.source.value})"
    yield _line([rank, name + _marks(row.notes), row.answered or "--", *map(_number, row.cells)])
    if any(cell.interval for cell in row.cells):
        yield _line(["", "", "", *(rf"{{\scriptsize {_interval(cell)}}}" for cell in row.cells)])


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
