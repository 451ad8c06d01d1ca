"""Tables of results: one value for reports, analyses, leaderboards, comparisons and statistics of data.

A cell is a plain value, a `Label`, or an `Estimate`: a number with what it is made of and how sure it is. How
a table looks is for its writers to say: `table_files` (CSV, JSON, Markdown and Parquet of an analysis),
`markdown`, `latex` and `terminal`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from inspect import signature
from typing import ParamSpec, TypeAlias

from eai.results.certainty import Cases, certainty_of_difference, certainty_of_rate
from eai.results.rate import Rate, rate_of

P = ParamSpec("P")

Plain: TypeAlias = str | int | float | bool | None

_SUPERSCRIPTS = str.maketrans("0123456789,", "⁰¹²³⁴⁵⁶⁷⁸⁹˒")


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its interval of 95 %.

    Attributes:
        value: the number; None if it is of nothing.
        low: the lower bound; None if there is no interval.
        high: the upper one.
        numerator: of a rate, its numerator.
        denominator: of a rate, its denominator.
        best: whether it is to stand out, such as the best of its column.
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
    def from_cases(cls, cases: Cases) -> Estimate:
        """The rate of what tasks add to it, in percent; its interval has the tasks' names as units."""
        rate, certainty = rate_of(case.share for case in cases), certainty_of_rate(cases)
        low, high = (None, None) if certainty is None else certainty.interval
        return cls(rate.percent, low, high, rate.numerator, rate.denominator)

    @classmethod
    def from_difference(cls, before: Cases, after: Cases) -> Estimate:
        """The second rate minus the first, in percentage points."""
        percents = [rate_of(case.share for case in cases).percent for cases in (before, after)]
        certainty = certainty_of_difference(before, after)
        if percents[0] is None or percents[1] is None:
            return cls(None)
        return cls(percents[1] - percents[0], *((None, None) if certainty is None else certainty.interval))

    @classmethod
    def from_rate(cls, rate: Rate) -> Estimate:
        """A rate in percent, without an interval."""
        return cls(rate.percent, numerator=rate.numerator, denominator=rate.denominator)

    def columns(self) -> dict[str, float | None]:
        """The parts that the estimate may have, by name."""
        return {name: getattr(self, name) for name in ESTIMATE_PARTS}

    def format_number(self, column: Column, nothing: str) -> str:
        """The number alone, as a column has it; or what stands for none."""
        if self.value is None:
            return nothing
        return short_number(self.value) if column.digits is None else f"{self.value:.{column.digits}f}"

    def __str__(self) -> str:
        if self.value is None:
            return ""
        made_of = "" if self.denominator is None else f" ({self.numerator:g}/{self.denominator:g})"
        bounds = "" if self.low is None else f" [{short_number(self.low)}, {short_number(self.high)}]"
        return f"{short_number(self.value)}{made_of}{bounds}"


ESTIMATE_PARTS = ("value", "low", "high", "numerator", "denominator")

NO_NUMBER = Estimate(None)
"""The cell of a number that there is not: writers show a dash, where None is an empty cell."""


@dataclass(frozen=True, slots=True)
class Label:
    """A text with more to it than its letters.

    Attributes:
        text: what is read.
        target: where it leads: in Markdown it is a link.
        origin: where what it names is from, if not from a run; such a label stands back.
        notes: numbers of footnotes, from 1.
        bold: whether it stands out.
        dim: whether it stands back.
    """

    text: str
    target: str | None = None
    origin: str = ""
    notes: tuple[int, ...] = ()
    bold: bool = False
    dim: bool = False

    def __str__(self) -> str:
        return f"{self.text} ({self.origin})" if self.origin else self.text


Cell: TypeAlias = Plain | Estimate | Label
Row: TypeAlias = tuple[Cell, ...]


@dataclass(frozen=True, slots=True)
class Column:
    """A column that is more than its name.

    Attributes:
        name: in files for programs.
        heading: what readers read over it; the name if empty.
        group: what stands over it and its neighbours, where a writer has room for it.
        alone: the heading where there is no room for groups, if it is another one.
        digits: how many digits after the point numbers have; as few as say enough if None.
        number: whether it is set as numbers are, to the right; None if its cells decide.
        notes: the numbers of the footnotes on the whole of it.
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
        name: that of its files.
        title: its heading.
        definition: what stands in it, in words: a sentence or several.
        columns: those that are no more than names, and others.
        rows: the cells of each row, one a column.
        shown: how many rows of a suite stand in the Markdown of an analysis; None for all.
        notes: the footnotes, the first is number 1.
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
        """A table for a terminal from its columns, each with its cells."""
        rows = zip(*(cells for _, cells in columns), strict=True)
        return cls("", title, "", tuple([column for column, _ in columns]), tuple(rows))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns."""
        return tuple([column if isinstance(column, str) else column.name for column in self.columns])

    @property
    def full_columns(self) -> list[Column]:
        """The columns in full: each knows whether it is one of numbers, and what stands over it."""
        found = []
        for place, each in enumerate(self.columns):
            column = Column(each) if isinstance(each, str) else each
            number = self._is_of_numbers(place) if column.is_number is None else column.is_number
            found.append(replace(column, heading=column.heading or column.name, is_number=number))
        return found

    def row_dicts(self) -> list[dict[str, Cell]]:
        """The rows as cells by the names of their columns."""
        names = self.names
        return [dict(zip(names, row, strict=True)) for row in self.rows]

    def select(self, columns: Sequence[str]) -> Table:
        """The table with these of its columns, in their order in it."""
        places = [place for place, name in enumerate(self.names) if name in columns]
        chosen = tuple([self.columns[place] for place in places])
        return replace(self, columns=chosen, rows=tuple(tuple(row[i] for i in places) for row in self.rows))

    def drop(self, columns: Collection[str]) -> Table:
        """The table but for some of its columns."""
        return self.select([name for name in self.names if name not in columns])

    def flat_columns(self) -> list[str]:
        """The columns of CSV: an estimate has one for each of its parts."""
        parts = zip(self.names, self._estimates(), strict=True)
        return [name for column, is_estimate in parts for name in _parts(column, is_estimate)]

    def flat_rows(self) -> Iterator[list[Plain]]:
        """The rows of CSV."""
        estimates = self._estimates()
        for row in self.rows:
            flat: list[Plain] = []
            for cell, is_estimate in zip(row, estimates, strict=True):
                if isinstance(cell, Estimate):
                    flat += cell.columns().values()
                elif isinstance(cell, Label):
                    flat.append(cell.text)
                else:
                    flat += [cell] * (len(ESTIMATE_PARTS) if is_estimate else 1)
            yield flat

    def _estimates(self) -> list[bool]:
        """Which columns are of estimates."""
        return [
            any(isinstance(row[place], Estimate) for row in self.rows) for place in range(len(self.columns))
        ]

    def _is_of_numbers(self, place: int) -> bool:
        return not any(isinstance(row[place], str | bool | Label) for row in self.rows)


def make_table(
    name: str,
    columns: tuple[str | Column, ...],
    *,
    title: str | None = None,
    max_shown_rows: int | None = None,
) -> Callable[[Callable[P, Iterable[Row]]], Callable[P, Table]]:
    """Makes of a function that gives rows one that gives their table, whose attributes these are.

    The docstring of the function says the rest: its first line is the title, if no other is given, and what
    stands below is the definition. In both, names in braces are arguments of the function.
    """

    def with_table(rows: Callable[P, Iterable[Row]]) -> Callable[P, Table]:
        first, _, below = (rows.__doc__ or "").partition("\n")
        heading, definition = first.removesuffix(".") if title is None else title, " ".join(below.split())

        @wraps(rows)
        def made(*arguments: P.args, **options: P.kwargs) -> Table:
            bound = signature(rows).bind(*arguments, **options)
            bound.apply_defaults()
            says, means = (text.format(**bound.arguments) for text in (heading, definition))
            return Table(name, says, means, columns, tuple(rows(*arguments, **options)), max_shown_rows)

        return made

    return with_table


def short_number(number: float | None) -> str:
    """A number as one reads it: percentages to a tenth, small numbers to two digits after the point."""
    if number is None or math.isnan(number):
        return ""
    return (
        f"{number:.0f}"
        if number == int(number)
        else f"{number:.1f}"
        if abs(number) >= 10
        else f"{number:.2f}"
    )


def superscript(numbers: Sequence[int]) -> str:
    """The marks of footnotes."""
    return ",".join(map(str, numbers)).translate(_SUPERSCRIPTS)


def _parts(column: str, is_estimate: bool) -> list[str]:
    if not is_estimate:
        return [column]
    return [column if part == "value" else f"{column}_{part}" for part in ESTIMATE_PARTS]
