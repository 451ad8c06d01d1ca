"""Files of records: one JSON object a line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from eai.abilities.codec import SCHEMA, record_from_json, record_to_json
from eai.abilities.record import Record
from eai.data.files import write_whole
from eai.errors import InputError


def write_records(path: Path, records: Iterable[Record]) -> None:
    """Write one record a line.

    Raises:
        InputError: the file cannot be written.
    """
    write_whole({path: (f"{line_of(record)}\n" for record in records)})


def line_of(record: Record) -> str:
    """A record as a file has it, without the end of the line."""
    return json.dumps(record_to_json(record), ensure_ascii=True)


def read_records(path: Path) -> Iterator[Record]:
    """Read a file of records.

    Raises:
        InputError: the file cannot be read, a line is not a record, or its answer is not the one that was
            scored.
    """
    try:
        with path.open(encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                if line.strip():
                    yield _parse(f"{path}, line {number}", line)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: expected a readable records.jsonl ({error})") from error


def _parse(place: str, line: str) -> Record:
    try:
        values = json.loads(line, strict=False)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{place}: expected a JSON object ({error})") from error
    if not isinstance(values, dict):
        raise InputError(f"{place}: expected a JSON object")
    schema = values.get("schema")
    if schema != SCHEMA:
        raise InputError(f"{place}: schema {schema!r}, expected {SCHEMA}")
    try:
        return record_from_json(values)
    except InputError as error:
        raise InputError(f"{place}: {error}") from error
