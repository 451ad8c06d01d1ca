"""Write files of records for tests, with the summary that commands write beside them."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from eai.base.files import write_files_atomically
from eai.results.record import Record
from eai.results.records import RecordBatch, RunShard, format_record_line


def write_records(path: Path, records: Iterable[Record]) -> None:
    """Write one record per line."""
    write_files_atomically({path: (f"{format_record_line(record)}\n" for record in records)})


def write_shard(folder: Path, shard: RunShard, batches: Iterable[RecordBatch]) -> None:
    """Write the records of a shard of a run."""
    write_files_atomically({folder / shard.records_file_name: (lines for lines, _ in batches)})
