"""Writes tables as files: CSV, JSON, Markdown and Parquet."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import get_type_hints

from eai.base.files import escape_unprintable, write_files_atomically
from eai.base.json_value import Json
from eai.results.lines import ALL_MODELS, MODEL, SUITE, SuiteKey, TidyTableLine
from eai.results.markdown import format_markdown_rows
from eai.results.parquet import import_parquet
from eai.results.table import Cell, Estimate, Plain, Table, TextCell

_FORMULA = re.compile(r"[=+\-@\t\r].")
"""Pattern of texts that a spreadsheet reads as a formula."""


def write_tables(folder: Path, name: str, tables: Sequence[Table], remarks: Sequence[str] = ()) -> list[Path]:
    """Write an analysis: a CSV file for each table, and all tables as ``name``.json and ``name``.md.

    Args:
        folder: the folder, which is created.
        name: name of the analysis.
        tables: the tables.
        remarks: further notes for readers, each a sentence.

    Raises:
        InputError: the folder cannot be written.
    """
    contents = {
        f"{table.name}.csv": format_csv(table.csv_column_names(), table.csv_rows()) for table in tables
    }
    contents[f"{name}.json"] = (
        json.dumps(_tables_to_json(tables, remarks), indent=1, ensure_ascii=False) + "\n"
    )
    contents[f"{name}.md"] = _format_markdown(name, tables, remarks)
    return write_files(folder, contents)


def write_files(folder: Path, contents: Mapping[str, str]) -> list[Path]:
    """Write files to a folder, given as a mapping from file names to texts. Return their paths.

    Raises:
        InputError: the folder cannot be written.
    """
    write_files_atomically({folder / file: text for file, text in contents.items()})
    return [folder / file for file in contents]


def format_csv(columns: Sequence[str], rows: Iterable[Sequence[Plain]]) -> str:
    """Return a table as the text of a CSV file. Unknown values become empty fields.

    Truth values become ``true`` and ``false``.

    Texts that spreadsheets read as formulas, such as ``=1+1``, get an apostrophe in front.
    """
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_escape_csv_value(value) for value in row] for row in rows)
    return file.getvalue()


def format_rows_as_csv(rows: Iterable[Mapping[str, Plain]]) -> str:
    """Return rows with equal columns as the text of a CSV file; without rows the text is empty."""
    row_list = list(rows)
    return format_csv(list(row_list[0]) if row_list else [], (list(row.values()) for row in row_list))


def format_lines_as_csv(kind: type[TidyTableLine], lines: Iterable[TidyTableLine]) -> str:
    """Return the lines of a tidy table as the text of a CSV file."""
    columns = [column.name for column in fields(kind)]
    return format_csv(columns, ([getattr(line, name) for name in columns] for line in lines))


def write_parquet(path: Path, kind: type[TidyTableLine], lines: Sequence[TidyTableLine]) -> None:
    """Write the lines of a tidy table as Parquet. Lone surrogates are written as escapes.

    Raises:
        EaiError: pyarrow is not installed.
        InputError: the file cannot be written.
    """
    pq = import_parquet()
    import pyarrow as pa

    kinds = {"str": pa.string(), "int": pa.int64(), "float": pa.float64(), "bool": pa.bool_()}
    hints = get_type_hints(kind)
    names = [column.name for column in fields(kind)]
    types = {name: kinds[str(getattr(hints[name], "__args__", (hints[name],))[0].__name__)] for name in names}
    table = pa.table(
        {
            name: pa.array([_escape_surrogates(getattr(line, name)) for line in lines], types[name])
            for name in names
        }
    )
    content = io.BytesIO()
    pq.write_table(table, content)
    write_files_atomically({path: content.getvalue()})


def _escape_surrogates(value: Plain) -> Plain:
    return value.encode(errors="backslashreplace").decode() if isinstance(value, str) else value


def _tables_to_json(tables: Sequence[Table], remarks: Sequence[str]) -> dict[str, Json]:
    return {
        "remarks": list(remarks),
        "tables": {
            table.name: {
                "title": table.title,
                "definition": table.definition,
                "rows": [
                    {name: _cell_to_json(cell) for name, cell in row.items()} for row in table.row_dicts()
                ],
            }
            for table in tables
        },
    }


def _cell_to_json(cell: Cell) -> Json:
    if not isinstance(cell, Estimate):
        return cell.text if isinstance(cell, TextCell) else cell
    return {
        name: value
        for name, value in cell.get_value_bounds_and_fraction_by_name().items()
        if value is not None or name == "value"
    }


def _format_markdown(name: str, tables: Sequence[Table], remarks: Sequence[str]) -> str:
    lines = [f"# {name.capitalize()}", "", *(line for remark in remarks for line in (remark, ""))]
    for table in tables:
        rows_by_heading = _group_rows_to_show_by_heading(table)
        lines += [f"## {table.title}", "", table.definition]
        if sum(map(len, rows_by_heading.values())) < len(table.rows):
            lines.append(f"All of it, and of each model, is in `{table.name}.csv`.")
        lines.append("")
        for heading, rows in rows_by_heading.items():
            lines += [f"### {heading}", ""] if heading else []
            columns_of_table = enumerate(table.columns_with_headings)
            indices = [
                i for i, column in columns_of_table if not heading or column.name not in (*SUITE, MODEL)
            ]
            columns = [table.columns_with_headings[index] for index in indices]
            lines += [*format_markdown_rows(columns, ([row[index] for index in indices] for row in rows)), ""]
        if not table.rows:
            lines += ["Nothing.", ""]
    return "\n".join(lines)


def _group_rows_to_show_by_heading(table: Table) -> dict[str, list[tuple[Cell, ...]]]:
    """Return the rows to show, grouped by heading: the suite and the model of a row.

    If a suite has rows about all models together (`ALL_MODELS`), its other rows are not shown.
    """
    rows = table.row_dicts()
    suites_with_all_models = {_get_suite_cells(row) for row in rows if row.get(MODEL) == ALL_MODELS}
    shown: dict[str, list[tuple[Cell, ...]]] = {}
    for row in rows:
        if row.get(MODEL) != ALL_MODELS and _get_suite_cells(row) in suites_with_all_models:
            continue
        heading = str(SuiteKey(*(str(row[name]) for name in SUITE))) if SUITE[0] in row else ""
        heading += f", {row[MODEL]}" if MODEL in row else ""
        of_suite = shown.setdefault(heading, [])
        if table.max_shown_rows is None or len(of_suite) < table.max_shown_rows:
            of_suite.append(tuple(row.values()))
    return {heading: rows for heading, rows in shown.items() if rows}


def _get_suite_cells(row: Mapping[str, Cell]) -> tuple[Cell | None, ...]:
    return tuple([row.get(name) for name in SUITE])


def _escape_csv_value(value: Plain) -> Plain:
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, str):
        return value
    text = escape_unprintable(value)
    return f"'{text}" if _FORMULA.match(text) else text
