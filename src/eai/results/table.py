"""Tables of results: one form for all analyses, written as CSV, JSON, Markdown and Parquet.

A cell is a plain value, a `Link`, or an `Estimate`: a number with what it is made of and how sure it is. In
CSV and Parquet an estimate is several columns, in JSON an object, in Markdown one cell.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TypeAlias, get_type_hints

from eai.abilities.verdict import Json
from eai.data.files import parquet, printable, write_whole
from eai.errors import InputError
from eai.results.certainty import Cases, certainty_of_rate
from eai.results.lines import Line
from eai.results.rate import rate_of
from eai.results.suites import MODEL, SUITE, TOGETHER, SuiteKey

_FORMULA = re.compile(r"[=+\-@\t\r].")
"""How a text begins that a spreadsheet takes for a formula."""

Plain: TypeAlias = str | int | float | bool | None


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its interval of 95 %.

    Attributes:
        value: the number; None if it is of nothing.
        low: the lower bound; None if there is no interval.
        high: the upper one.
        numerator: of a rate, its numerator.
        denominator: of a rate, its denominator.
    """

    value: float | None
    low: float | None = None
    high: float | None = None
    numerator: float | None = None
    denominator: float | None = None

    @classmethod
    def of(cls, cases: Cases) -> Estimate:
        """The rate of what tasks add to it, in percent; its interval has the tasks' names as units."""
        rate, certainty = rate_of(case.share for case in cases), certainty_of_rate(cases)
        low, high = (None, None) if certainty is None else certainty.interval
        return cls(rate.percent, low, high, rate.numerator, rate.denominator)

    def columns(self) -> dict[str, float | None]:
        """The parts that the estimate may have, by name."""
        return {name: getattr(self, name) for name in ESTIMATE_PARTS}

    def __str__(self) -> str:
        if self.value is None:
            return ""
        made_of = "" if self.denominator is None else f" ({self.numerator:g}/{self.denominator:g})"
        bounds = "" if self.low is None else f" [{_short(self.low)}, {_short(self.high)}]"
        return f"{_short(self.value)}{made_of}{bounds}"


ESTIMATE_PARTS = ("value", "low", "high", "numerator", "denominator")


@dataclass(frozen=True, slots=True)
class Link:
    """A text that leads somewhere: in Markdown a link, elsewhere the text.

    Attributes:
        text: what is read.
        target: where it leads.
    """

    text: str
    target: str

    def __str__(self) -> str:
        return f"[{self.text}]({self.target})"


Cell: TypeAlias = Plain | Estimate | Link


@dataclass(frozen=True, slots=True)
class Table:
    """A table of results.

    Attributes:
        name: that of its files.
        title: its heading.
        definition: what stands in it, in words: a sentence or several.
        columns: the names of the columns.
        rows: the cells of each row, one a column.
        shown: how many rows of a suite stand in Markdown; None for all.
    """

    name: str
    title: str
    definition: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    shown: int | None = None

    def flat_columns(self) -> list[str]:
        """The columns of CSV: an estimate has one for each of its parts."""
        return [name for column in self.columns for name in self._parts(column)]

    def flat_rows(self) -> Iterator[list[Plain]]:
        """The rows of CSV."""
        estimates = [self._is_estimate(column) for column in self.columns]
        for row in self.rows:
            flat: list[Plain] = []
            for cell, is_estimate in zip(row, estimates, strict=True):
                if isinstance(cell, Estimate):
                    flat += cell.columns().values()
                elif isinstance(cell, Link):
                    flat.append(cell.text)
                else:
                    flat += [cell] * (len(ESTIMATE_PARTS) if is_estimate else 1)
            yield flat

    def _parts(self, column: str) -> list[str]:
        if not self._is_estimate(column):
            return [column]
        return [column if part == "value" else f"{column}_{part}" for part in ESTIMATE_PARTS]

    def _is_estimate(self, column: str) -> bool:
        place = self.columns.index(column)
        return any(isinstance(row[place], Estimate) for row in self.rows)


def write_tables(folder: Path, name: str, tables: Sequence[Table], remarks: Sequence[str] = ()) -> list[Path]:
    """Write an analysis: a CSV file a table, and all of them as ``name``.json and ``name``.md.

    Args:
        folder: where; it is made.
        name: of the analysis.
        tables: its tables.
        remarks: what a reader must know besides, each a sentence.

    Raises:
        InputError: the folder cannot be written.
    """
    contents = {f"{table.name}.csv": csv_text(table.flat_columns(), table.flat_rows()) for table in tables}
    contents[f"{name}.json"] = json.dumps(_json(tables, remarks), indent=1, ensure_ascii=False) + "\n"
    contents[f"{name}.md"] = _markdown(name, tables, remarks)
    return write_files(folder, contents)


def write_files(folder: Path, contents: Mapping[str, str]) -> list[Path]:
    """Write texts by file name.

    Raises:
        InputError: the folder cannot be written.
    """
    write_whole({folder / file: text for file, text in contents.items()})
    return [folder / file for file in contents]


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[Plain]]) -> str:
    """A CSV file: ``true`` and ``false``, nothing for what is not known.

    Spreadsheets take some texts for formulas, such as ``=1+1``: an apostrophe stands before them.
    """
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_written(value) for value in row] for row in rows)
    return file.getvalue()


def lines_csv(kind: type[Line], lines: Iterable[Line]) -> str:
    """A tidy table as CSV."""
    columns = [column.name for column in fields(kind)]
    return csv_text(columns, ([getattr(line, name) for name in columns] for line in lines))


def write_parquet(path: Path, kind: type[Line], lines: Sequence[Line]) -> None:
    """Write a tidy table as Parquet.

    Raises:
        EaiError: pyarrow is not installed.
        InputError: the file cannot be written.
    """
    pq = parquet()
    import pyarrow as pa

    kinds = {"str": pa.string(), "int": pa.int64(), "float": pa.float64(), "bool": pa.bool_()}
    hints = get_type_hints(kind)
    names = [column.name for column in fields(kind)]
    types = {name: kinds[str(getattr(hints[name], "__args__", (hints[name],))[0].__name__)] for name in names}
    table = pa.table({name: pa.array([getattr(line, name) for line in lines], types[name]) for name in names})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(table, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error})") from error


def _json(tables: Sequence[Table], remarks: Sequence[str]) -> dict[str, Json]:
    return {
        "remarks": list(remarks),
        "tables": {
            table.name: {
                "title": table.title,
                "definition": table.definition,
                "rows": [
                    {name: _json_cell(cell) for name, cell in zip(table.columns, row, strict=True)}
                    for row in table.rows
                ],
            }
            for table in tables
        },
    }


def _json_cell(cell: Cell) -> Json:
    if not isinstance(cell, Estimate):
        return cell.text if isinstance(cell, Link) else cell
    return {name: value for name, value in cell.columns().items() if value is not None or name == "value"}


def _markdown(name: str, tables: Sequence[Table], remarks: Sequence[str]) -> str:
    lines = [f"# {name.capitalize()}", "", *(line for remark in remarks for line in (remark, ""))]
    for table in tables:
        lines += [f"## {table.title}", "", table.definition, *_rest(table), ""]
        for heading, rows in _shown(table).items():
            lines += [f"### {heading}", ""] if heading else []
            columns = [column for column in table.columns if not heading or column not in (*SUITE, MODEL)]
            places = [table.columns.index(column) for column in columns]
            lines += [_row(columns), "|" + "---|" * len(columns)]
            lines += [_row([_told(row[place]) for place in places]) for row in rows]
            lines.append("")
        if not table.rows:
            lines += ["Nothing.", ""]
    return "\n".join(lines)


def _shown(table: Table) -> dict[str, list[tuple[Cell, ...]]]:
    """The rows that a reader is shown by suite and model: where models stand together, those, else all."""
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.rows]
    if any(row.get(MODEL) == TOGETHER for row in rows):
        rows = [row for row in rows if row[MODEL] == TOGETHER]
    shown: dict[str, list[tuple[Cell, ...]]] = {}
    for row in rows:
        heading = str(SuiteKey(*(str(row[name]) for name in SUITE))) if SUITE[0] in row else ""
        heading += f", {row[MODEL]}" if MODEL in row else ""
        of_suite = shown.setdefault(heading, [])
        if table.shown is None or len(of_suite) < table.shown:
            of_suite.append(tuple(row.values()))
    return {heading: rows for heading, rows in shown.items() if rows}


def _rest(table: Table) -> Iterator[str]:
    shown = sum(map(len, _shown(table).values()))
    if shown < len(table.rows):
        yield f"All of it, and of each model, is in `{table.name}.csv`."


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(printable(c).replace("|", "\\|").replace("\n", " ") for c in cells) + " |"


def _told(cell: Cell) -> str:
    match cell:
        case None:
            return ""
        case bool():
            return "yes" if cell else "no"
        case float():
            return _short(cell)
        case _:
            return str(cell)


def _short(number: float | None) -> str:
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


def _written(value: Plain) -> Plain:
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, str):
        return value
    text = printable(value)
    return f"'{text}" if _FORMULA.match(text) else text
