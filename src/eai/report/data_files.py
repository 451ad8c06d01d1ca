"""Tables for programs: one JSON file, and one CSV file with a line a number."""

from __future__ import annotations

import json
from collections.abc import Sequence

from eai.abilities.verdict import Json
from eai.report.row import Cell, Row
from eai.report.table import Table
from eai.report.table_specs import ColumnSpec
from eai.results.certainty import Certainty
from eai.results.table_files import csv_text

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


def tables_json(tables: Sequence[Table]) -> str:
    """All tables, each number with what it is made of; percentages unrounded."""
    content: list[Json] = [
        {
            "name": table.name,
            "title": table.title,
            "protocol": table.protocol.value,
            "domain": table.domain,
            "unit": "percent",
            "rows": [_row(table, row) for row in table.rows],
            "notes": list(table.notes),
        }
        for table in tables
    ]
    return json.dumps({"tables": content}, indent=1, ensure_ascii=False) + "\n"


def tables_csv(tables: Sequence[Table]) -> str:
    """All numbers of all tables, one a line."""
    lines = [
        _line(table, row, column, cell)
        for table in tables
        for row in table.rows
        for column, cell in zip(table.columns, row.cells, strict=True)
        if cell.percent is not None
    ]
    return csv_text(CSV_COLUMNS, lines)


def _line(table: Table, row: Row, column: ColumnSpec, cell: Cell) -> list[str | float | None]:
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


def _row(table: Table, row: Row) -> Json:
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
