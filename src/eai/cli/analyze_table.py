"""``eai analyze table``: records as tidy tables."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.verdict import Json
from eai.cli.analyzed import Records, tables_of
from eai.cli.console import counted, tell
from eai.cli.options import AsJson
from eai.cli.store import DataFolder
from eai.results.lines import TABLES
from eai.results.table_files import lines_csv, write_files, write_parquet


class Format(str, Enum):
    """How tables are written."""

    CSV = "csv"
    PARQUET = "parquet"


def table(
    records: Records,
    out: Annotated[Path, typer.Option(help="The folder for the tables.")],
    formats: Annotated[
        list[Format] | None,
        typer.Option(
            "--format",
            metavar="FORMAT",
            help="csv, if not given, or parquet, which needs the extra 'analysis'.",
        ),
    ] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write records as tidy tables: a line an answer, with what its task is like; a step, goal, atom, clause.

    Example: eai analyze table scores --out tables --format csv --format parquet
    """
    tables = tables_of(records, data)
    for written in dict.fromkeys(formats or [Format.CSV]):
        for name, kind in TABLES.items():
            lines = getattr(tables, name)
            if written is Format.PARQUET:
                write_parquet(out / f"{name}.parquet", kind, lines)
            else:
                write_files(out, {f"{name}.csv": lines_csv(kind, lines)})
    sizes: dict[str, Json] = {name: len(getattr(tables, name)) for name in TABLES}
    told = ", ".join(counted(len(getattr(tables, name)), name.removesuffix("s")) for name in TABLES)
    tell(f"{told}; in {out}", value={"folder": str(out), "lines": sizes}, as_json=as_json)
