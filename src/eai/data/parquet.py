"""Parquet files, which only those need whose answers or tables are so many; what reads them is an extra."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from eai.errors import EaiError, InputError, how_to_install


def parquet() -> Any:
    """What reads and writes Parquet files: ``pyarrow.parquet``.

    Raises:
        EaiError: pyarrow is not installed.
    """
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise EaiError(f"Parquet needs pyarrow: {how_to_install('analysis')}") from error
    return pyarrow.parquet


def read_columns(path: Path, names: Sequence[str]) -> list[dict[str, object]]:
    """The rows of a Parquet file, each with these columns; others are not read.

    Raises:
        EaiError: pyarrow is not installed.
        InputError: the file cannot be read, or has no such column.
    """
    reader = parquet()
    try:
        there = reader.read_schema(path).names
        for name in names:
            if name not in there:
                raise InputError(f'{path}: the column "{name}" is missing')
        rows: list[dict[str, object]] = reader.read_table(path, columns=list(names)).to_pylist()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: expected a Parquet file ({str(error).splitlines()[0]})") from error
    return rows
