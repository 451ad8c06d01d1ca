"""Tables as files: CSV, JSON, Markdown and Parquet."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import get_type_hints

from eai.base.errors import InputError
from eai.base.files import escape_unprintable, write_whole
from eai.base.json_value import Json
from eai.results.lines import ALL_MODELS, MODEL, SUITE, SuiteKey, TidyLine
from eai.results.markdown import rows_markdown
from eai.results.parquet import parquet
from eai.results.table import Cell, Estimate, Label, Plain, Table

_FORMULA = re.compile(r"[=+\-@\t\r].")
"""How a text begins that a spreadsheet takes for a formula."""


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


def rows_csv(rows: Iterable[Mapping[str, Plain]]) -> str:
    """Rows with the same columns as CSV; of none nothing is known but that."""
    written = list(rows)
    return csv_text(list(written[0]) if written else [], (list(row.values()) for row in written))


def lines_csv(kind: type[TidyLine], lines: Iterable[TidyLine]) -> str:
    """A tidy table as CSV."""
    columns = [column.name for column in fields(kind)]
    return csv_text(columns, ([getattr(line, name) for name in columns] for line in lines))


def write_parquet(path: Path, kind: type[TidyLine], lines: Sequence[TidyLine]) -> None:
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
                "rows": [{name: _json_cell(cell) for name, cell in row.items()} for row in table.row_dicts()],
            }
            for table in tables
        },
    }


def _json_cell(cell: Cell) -> Json:
    if not isinstance(cell, Estimate):
        return cell.text if isinstance(cell, Label) else cell
    return {name: value for name, value in cell.columns().items() if value is not None or name == "value"}


def _markdown(name: str, tables: Sequence[Table], remarks: Sequence[str]) -> str:
    lines = [f"# {name.capitalize()}", "", *(line for remark in remarks for line in (remark, ""))]
    for table in tables:
        shown = _shown(table)
        lines += [f"## {table.title}", "", table.definition]
        if sum(map(len, shown.values())) < len(table.rows):
            lines.append(f"All of it, and of each model, is in `{table.name}.csv`.")
        lines.append("")
        for heading, rows in shown.items():
            lines += [f"### {heading}", ""] if heading else []
            described = enumerate(table.full_columns)
            places = [i for i, column in described if not heading or column.name not in (*SUITE, MODEL)]
            columns = [table.full_columns[place] for place in places]
            lines += [*rows_markdown(columns, ([row[place] for place in places] for row in rows)), ""]
        if not table.rows:
            lines += ["Nothing.", ""]
    return "\n".join(lines)


def _shown(table: Table) -> dict[str, list[tuple[Cell, ...]]]:
    """The rows that a reader is shown by suite and model: where models stand together, those, else all."""
    rows = table.row_dicts()
    if any(row.get(MODEL) == ALL_MODELS for row in rows):
        rows = [row for row in rows if row[MODEL] == ALL_MODELS]
    shown: dict[str, list[tuple[Cell, ...]]] = {}
    for row in rows:
        heading = str(SuiteKey(*(str(row[name]) for name in SUITE))) if SUITE[0] in row else ""
        heading += f", {row[MODEL]}" if MODEL in row else ""
        of_suite = shown.setdefault(heading, [])
        if table.max_shown_rows is None or len(of_suite) < table.max_shown_rows:
            of_suite.append(tuple(row.values()))
    return {heading: rows for heading, rows in shown.items() if rows}


def _written(value: Plain) -> Plain:
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, str):
        return value
    text = escape_unprintable(value)
    return f"'{text}" if _FORMULA.match(text) else text
