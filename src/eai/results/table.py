"""Tables of results for reports, analyses, leaderboards, comparisons and statistics of data.

A cell is a plain value, a `TextCell`, or an `Estimate` (a number with its fraction and its interval). Writers
decide on the form: `table_files` (CSV, JSON, Markdown and Parquet of an analysis), `markdown`, `latex` and
`terminal`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from inspect import signature
from typing import ParamSpec, TypeAlias

from eai.results.certainty import TaskRateContributions, compute_difference_intervals, compute_rate_intervals
from eai.results.rate import Rate, compute_rate

P = ParamSpec("P")

Plain: TypeAlias = str | int | float | bool | None

_SUPERSCRIPTS = str.maketrans("0123456789,", "⁰¹²³⁴⁵⁶⁷⁸⁹˒")


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its 95 % interval.

    Attributes:
        value: the number; None if it is unknown.
        low: lower bound; None if there is no interval.
        high: upper bound; None if there is no interval.
        numerator: numerator, if the number is a rate.
        denominator: denominator, if the number is a rate.
        best: whether the number is emphasised, such as the best of its column.
        notes: numbers of footnotes, from 1.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    numerator: float | None = None
    denominator: float | None = None
    best: bool = False
    notes: tuple[int, ...] = ()

    @classmethod
    def from_task_rate_contributions(cls, contributions: TaskRateContributions) -> Estimate:
        """Return a rate in percent with its interval. The interval counts near copies of a task as one unit.

        Near copies are the tasks with the same `name`.
        """
        rate = compute_rate(contribution.share for contribution in contributions)
        certainty = compute_rate_intervals(contributions)
        low, high = (None, None) if certainty is None else certainty.interval
        return cls(rate.percent, low, high, rate.numerator, rate.denominator)

    @classmethod
    def estimate_rate_difference(
        cls, before: TaskRateContributions, after: TaskRateContributions
    ) -> Estimate:
        """Return the estimate of the second rate minus the first, in percentage points."""
        first = compute_rate(contribution.share for contribution in before).percent
        second = compute_rate(contribution.share for contribution in after).percent
        certainty = compute_difference_intervals(before, after)
        if first is None or second is None or certainty is None:  # a denominator is zero
            return cls(None)
        return cls(second - first, *certainty.interval)

    @classmethod
    def from_rate(cls, rate: Rate) -> Estimate:
        """Return the estimate of a rate in percent, without an interval."""
        return cls(rate.percent, numerator=rate.numerator, denominator=rate.denominator)

    def get_value_bounds_and_fraction_by_name(self) -> dict[str, float | None]:
        """Return the numbers of this estimate, such as the lower bound of its interval, by name.

        A number is None if it is unknown.
        """
        return {name: getattr(self, name) for name in ESTIMATE_PARTS}

    def format_number(self, column: Column, missing_text: str) -> str:
        """Return the number as text, with the digits of the column; ``missing_text`` if it is None."""
        if self.value is None:
            return missing_text
        return format_short_number(self.value) if column.digits is None else f"{self.value:.{column.digits}f}"

    def __str__(self) -> str:
        if self.value is None:
            return ""
        made_of = "" if self.denominator is None else f" ({self.numerator:g}/{self.denominator:g})"
        bounds = (
            ""
            if self.low is None
            else f" [{format_short_number(self.low)}, {format_short_number(self.high)}]"
        )
        return f"{format_short_number(self.value)}{made_of}{bounds}"


ESTIMATE_PARTS = ("value", "low", "high", "numerator", "denominator")

NO_NUMBER = Estimate(None)
"""Cell of an unknown number, printed as a dash. The cell None is printed as an empty text."""


@dataclass(frozen=True, slots=True)
class TextCell:
    """A cell with a text. It may have a link, footnotes, emphasis, and the origin of the text.

    Attributes:
        text: the text.
        target: address of the text's link; None for no link. Markdown shows the text as a link.
        origin: source of the numbers about the named item, such as ``paper``, shown after the text; empty for
            a run. A terminal dims a cell with an origin.
        notes: numbers of footnotes, from 1.
        bold: whether the text is emphasized.
        dim: whether the text is shown less prominently.
    """

    text: str
    target: str | None = None
    origin: str = ""
    notes: tuple[int, ...] = ()
    bold: bool = False
    dim: bool = False

    def __str__(self) -> str:
        return f"{self.text} ({self.origin})" if self.origin else self.text


Cell: TypeAlias = Plain | Estimate | TextCell
Row: TypeAlias = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """A column with its heading and format.

    Attributes:
        name: name in files for programs.
        heading: heading for readers; the name if empty.
        group: heading over this and neighbouring columns, if a writer supports it.
        heading_without_group: heading for writers that do not support groups; empty if it is ``heading``.
        digits: number of digits after the point; as few as needed if None.
        is_number: whether the cells are aligned right as numbers; None if their types decide.
        notes: numbers of footnotes on the whole column.
    """

    name: str
    heading: str = ""
    group: str = ""
    heading_without_group: str = ""
    digits: int | None = None
    is_number: bool | None = None
    notes: tuple[int, ...] = ()


NamedCells: TypeAlias = tuple[str | Column, Sequence[Cell]]
"""A column with its cells."""


@dataclass(frozen=True, slots=True)
class Table:
    """A table of results.

    Attributes:
        name: name of its files.
        title: heading of the table.
        definition: meaning of the numbers in sentences.
        columns: each column, as a name or as a `Column` with its format.
        rows: cells of each row, one for each column.
        max_shown_rows: maximum number of rows below a heading of the Markdown file, which names a suite and a
            model; None for all.
        notes: footnotes; the first has number 1.
    """

    name: str
    title: str
    definition: str
    columns: tuple[str | Column, ...]
    rows: tuple[Row, ...]
    max_shown_rows: int | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def from_columns(cls, title: str, columns: Sequence[NamedCells]) -> Table:
        """Return a table for a terminal, made from columns with their cells."""
        rows = zip(*(cells for _, cells in columns), strict=True)
        return cls("", title, "", tuple([column for column, _ in columns]), tuple(rows))

    @property
    def column_names(self) -> tuple[str, ...]:
        """Names of the columns, in order."""
        return tuple([column if isinstance(column, str) else column.name for column in self.columns])

    @property
    def columns_with_headings(self) -> list[Column]:
        """The columns, each with its heading and whether it has numbers."""
        columns = []
        for index, column_or_name in enumerate(self.columns):
            column = Column(column_or_name) if isinstance(column_or_name, str) else column_or_name
            number = self._has_numbers(index) if column.is_number is None else column.is_number
            columns.append(replace(column, heading=column.heading or column.name, is_number=number))
        return columns

    def row_dicts(self) -> list[dict[str, Cell]]:
        """Return each row as a mapping from column names to cells."""
        names = self.column_names
        return [dict(zip(names, row, strict=True)) for row in self.rows]

    def select_columns(self, columns: Sequence[str]) -> Table:
        """Return the table with only some columns, in the table's order."""
        indices = [index for index, name in enumerate(self.column_names) if name in columns]
        selected = tuple([self.columns[index] for index in indices])
        return replace(
            self, columns=selected, rows=tuple(tuple(row[i] for i in indices) for row in self.rows)
        )

    def drop_columns(self, columns: Collection[str]) -> Table:
        """Return the table without some columns."""
        return self.select_columns([name for name in self.column_names if name not in columns])

    def csv_column_names(self) -> list[str]:
        """Return the names of the columns in CSV: each number of an estimate has a column of its own."""
        parts = zip(self.column_names, self._list_whether_columns_have_estimates(), strict=True)
        return [name for column, is_estimate in parts for name in _make_csv_column_names(column, is_estimate)]

    def csv_rows(self) -> Iterator[list[Plain]]:
        """Yield the rows of the table as in CSV, with a cell for each number of an estimate."""
        estimates = self._list_whether_columns_have_estimates()
        for row in self.rows:
            flat: list[Plain] = []
            for cell, is_estimate in zip(row, estimates, strict=True):
                if isinstance(cell, Estimate):
                    flat += cell.get_value_bounds_and_fraction_by_name().values()
                else:
                    flat.append(cell.text if isinstance(cell, TextCell) else cell)
                    flat += [None] * (len(ESTIMATE_PARTS) - 1 if is_estimate else 0)
            yield flat

    def _list_whether_columns_have_estimates(self) -> list[bool]:
        return [
            any(isinstance(row[index], Estimate) for row in self.rows) for index in range(len(self.columns))
        ]

    def _has_numbers(self, column_index: int) -> bool:
        return not any(isinstance(row[column_index], str | bool | TextCell) for row in self.rows)


def collect_rows_in_table(
    name: str,
    columns: tuple[str | Column, ...],
    *,
    title: str | None = None,
    max_shown_rows: int | None = None,
) -> Callable[[Callable[P, Iterable[Row]]], Callable[P, Table]]:
    """Return a decorator that turns a function that yields rows into a function that returns a table.

    The first line of the function's docstring is the title of the table, unless ``title`` is given. The other
    lines are its definition. Names in braces in either text are replaced by arguments of the function.
    """

    def make_function_that_returns_table(rows: Callable[P, Iterable[Row]]) -> Callable[P, Table]:
        first, _, below = (rows.__doc__ or "").partition("\n")
        heading, definition = first.removesuffix(".") if title is None else title, " ".join(below.split())

        @wraps(rows)
        def make_table_from_yielded_rows(*arguments: P.args, **options: P.kwargs) -> Table:
            bound = signature(rows).bind(*arguments, **options)
            bound.apply_defaults()
            title_text, definition_text = (text.format(**bound.arguments) for text in (heading, definition))
            return Table(
                name, title_text, definition_text, columns, tuple(rows(*arguments, **options)), max_shown_rows
            )

        return make_table_from_yielded_rows

    return make_function_that_returns_table


def format_short_number(number: float | None) -> str:
    """Return a number as text: one decimal, two between -10 and 10, none if whole; empty for None, NaN."""
    if number is None or math.isnan(number):
        return ""
    if number == int(number):
        return f"{number:.0f}"
    if abs(number) >= 10:
        return f"{number:.1f}"
    return f"{number:.2f}"


def format_superscript(numbers: Sequence[int]) -> str:
    """Return the numbers of footnotes as superscript characters."""
    return ",".join(map(str, numbers)).translate(_SUPERSCRIPTS)


def _make_csv_column_names(column: str, is_estimate: bool) -> list[str]:
    if not is_estimate:
        return [column]
    return [column if part == "value" else f"{column}_{part}" for part in ESTIMATE_PARTS]
