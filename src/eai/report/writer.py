"""Writing a report: its tables for readers and for programs, into a folder.

For programs there is one JSON file, and one CSV file with a line a number.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from eai.abilities.verdict import Json
from eai.data.files import write_whole
from eai.errors import InputError, did_you_mean
from eai.report.cost import cost_csv, cost_section
from eai.report.document import Plot, agreements, report_markdown
from eai.report.ranking import Cell, Ranking, Row, with_best_marked
from eai.report.rankings import besides, experiments
from eai.report.run_summary import RunSummary, plain_runs
from eai.report.table_specs import ColumnSpec
from eai.results import latex
from eai.results.certainty import Certainty
from eai.results.cost import PriceList
from eai.results.table_files import csv_text


@dataclass(frozen=True, slots=True)
class Narrow:
    """The part of a table that is shown.

    Attributes:
        models: the models, by name, or all if empty.
        columns: the columns, by their own heading or that above them, in any case; all if empty.
        intervals: whether intervals stand below the numbers.
    """

    models: Collection[str] = ()
    columns: Collection[str] = ()
    intervals: bool = True

    def tables(self, tables: Sequence[Ranking]) -> list[Ranking]:
        """The shown parts of tables; one of which nothing is shown is left out.

        Args:
            tables: the tables.

        Raises:
            InputError: there is no such model or column in any of them.
        """
        _check("--models", self.models, {row.model for table in tables for row in table.rows})
        headings = {heading for table in tables for column in table.columns for heading in _headings(column)}
        _check("--columns", [name.casefold() for name in self.columns], headings)
        return [narrow for table in tables if (narrow := self._table(table)) is not None]

    def _table(self, table: Ranking) -> Ranking | None:
        wanted = {name.casefold() for name in self.columns}
        places = [i for i, column in enumerate(table.columns) if not wanted or wanted & _headings(column)]
        rows = [row for row in table.rows if not self.models or row.model in self.models]
        if not places or not rows:
            return None
        columns = tuple(table.columns[i] for i in places)
        rows = [replace(row, cells=tuple(row.cells[i] for i in places)) for row in rows]
        column_notes = [table.column_notes[i] for i in places]
        used = {number for numbers in column_notes for number in numbers}
        used |= {number for row in rows for numbers in _notes_on(row) for number in numbers}
        new = {number: place for place, number in enumerate(sorted(used), 1)}
        ranks = [row.rank for row in rows]
        renumbered = [
            replace(
                row,
                rank=None if row.rank is None else 1 + sum(r is not None and r < row.rank for r in ranks),
                notes=tuple(new[n] for n in row.notes),
                cells=tuple(replace(cell, notes=tuple(new[n] for n in cell.notes)) for cell in row.cells),
            )
            for row in rows
        ]
        return replace(
            table,
            columns=columns,
            column_notes=tuple(tuple(new[n] for n in numbers) for numbers in column_notes),
            rows=tuple(with_best_marked(columns, renumbered)),
            notes=tuple(table.notes[number - 1] for number in sorted(used)),
        )


WHOLE = Narrow()
"""All of every table."""


def write_tables(
    folder: Path,
    runs: Sequence[RunSummary],
    tables: Sequence[Ranking],
    plots: Sequence[Plot],
    *,
    with_paper: bool,
    narrow: Narrow = WHOLE,
    prices: PriceList | None = None,
) -> int:
    """Write ``report.md``, ``report.tex`` with ``tables.tex``, ``tables.json`` and ``tables.csv``.

    Experiments have tables of their own. With the paper there is also what it reports besides. Where records
    say what their answers took, there is ``cost.csv``.

    Args:
        folder: where the files go.
        runs: all runs, experiments too.
        tables: the tables of the plain runs.
        plots: the plots of the plain runs.
        with_paper: whether the paper's models appear beside ours.
        narrow: what of them is shown in LaTeX, where a page has an end.
        prices: what tokens cost that were not priced when they were asked for.

    Raises:
        InputError: a model or column to be shown is in none of them.

    Returns:
        how many tables were written.
    """
    plain = plain_runs(runs)
    tried = experiments(runs)
    others = besides(plain) if with_paper else []
    written = [*tables, *tried, *others]
    compared = agreements(plain) if with_paper else []
    cost = "\n".join(cost_section(runs, prices, with_paper=with_paper))
    contents = {
        "report.md": report_markdown(runs, tables, tried, others, compared, cost, plots),
        "tables.tex": "\n".join([*_latex(written, narrow)]),
        "report.tex": f"{latex.PREAMBLE}\\input{{tables}}\n{latex.ENDING}",
        "tables.json": rankings_json(written),
        "tables.csv": rankings_csv(written),
    }
    if (paid := cost_csv(runs, prices)) is not None:
        contents["cost.csv"] = paid
    write_whole({folder / name: text for name, text in contents.items()})
    return len(written)


def _headings(column: ColumnSpec) -> set[str]:
    return {column.group.casefold(), column.label.casefold()}


def _notes_on(row: Row) -> list[tuple[int, ...]]:
    return [row.notes, *(cell.notes for cell in row.cells)]


def _check(option: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"{option}: no table has {name!r}{did_you_mean(name, sorted(known))}")


def _latex(tables: Sequence[Ranking], narrow: Narrow) -> Iterator[str]:
    """Every table in LaTeX."""
    for table in narrow.tables(tables):
        label = ":".join((table.name, _slug(table.domain), _slug(table.protocol.value)))
        yield latex.table_latex(table.table(), label=label, intervals=narrow.intervals)


def _slug(text: str) -> str:
    return "".join(c if c.isascii() and c.isalnum() else "-" for c in text)


CSV_COLUMNS = (
    "table",
    "protocol",
    "domain",
    "model",
    "source",
    "rank",
    "ability",
    "metric",
    "percent",
    "numerator",
    "denominator",
    "low",
    "high",
    "low_by_task",
    "high_by_task",
    "design_effect",
    "effective_tasks",
    "answered",
    "tasks",
)
"""The columns of the CSV file."""


def rankings_json(tables: Sequence[Ranking]) -> str:
    """All tables, each number with what it is made of; percentages unrounded."""
    content: list[Json] = [
        {
            "name": table.name,
            "title": table.title,
            "protocol": table.protocol.value,
            "domain": table.domain,
            "unit": "percent",
            "rows": [_row_json(table, row) for row in table.rows],
            "notes": list(table.notes),
        }
        for table in tables
    ]
    return json.dumps({"tables": content}, indent=1, ensure_ascii=False) + "\n"


def rankings_csv(tables: Sequence[Ranking]) -> str:
    """All numbers of all tables, one a line."""
    lines = [
        _line(table, row, column, cell)
        for table in tables
        for row in table.rows
        for column, cell in zip(table.columns, row.cells, strict=True)
        if cell.percent is not None
    ]
    return csv_text(CSV_COLUMNS, lines)


def _line(table: Ranking, row: Row, column: ColumnSpec, cell: Cell) -> list[str | float | None]:
    return [
        table.name,
        table.protocol.value,
        table.domain,
        row.model,
        row.source.value,
        row.rank,
        column.ability.value if column.ability else "all",
        column.metric,
        cell.percent,
        cell.rate.numerator if cell.rate else None,
        cell.rate.denominator if cell.rate else None,
        *(_certainty(cell.certainty) if cell.certainty else [None] * 6),
        cell.coverage.answered if cell.coverage else None,
        cell.coverage.tasks if cell.coverage else None,
    ]


def _certainty(certainty: Certainty) -> list[float | None]:
    return [
        *certainty.interval,
        *certainty.by_task,
        certainty.design_effect,
        certainty.effective_tasks,
    ]


def _row_json(table: Ranking, row: Row) -> Json:
    return {
        "model": row.model,
        "source": row.source.value,
        "rank": row.rank,
        "coverage": None if row.coverage is None else row.coverage.to_json(),
        "notes": list(row.notes),
        "cells": [
            {
                "ability": column.ability.value if column.ability else None,
                "metric": column.metric,
                "percent": cell.percent,
                "numerator": cell.rate.numerator if cell.rate else None,
                "denominator": cell.rate.denominator if cell.rate else None,
                "interval": list(cell.certainty.interval) if cell.certainty else None,
                "interval_by_task": list(cell.certainty.by_task) if cell.certainty else None,
                "design_effect": cell.certainty.design_effect if cell.certainty else None,
                "effective_tasks": cell.certainty.effective_tasks if cell.certainty else None,
                "best": cell.best,
                "notes": [*cell.notes, *notes],
            }
            for column, notes, cell in zip(table.columns, table.column_notes, row.cells, strict=True)
        ],
    }
