"""Keeps the scored answers of an interrupted command, so that the same command only scores the others.

Records are appended to a partial file, in the folder of the final file. The name of a partial file contains a
digest of answers and options, so other answers or options have another partial file.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from eai.base.files import raise_write_errors_as_input_errors, read_content, write_files_atomically
from eai.results.records import RECORDS, SUMMARY, RecordBatch, format_summary, read_records
from eai.results.responses import ResponseFile
from eai.results.totals import RunTotals

_DIGEST_LENGTH = 16
"""Number of hexadecimal digits in the names of partial files."""


def get_path_of_partial_file(
    file: Path, settings: Sequence[object], answers: ResponseFile, read_files: Iterable[Path] = ()
) -> Path:
    """Return the path of a partial file, which keeps the scored answers of a command until it ends.

    Args:
        file: the file of records, in its final place.
        settings: values on which the records depend. Their texts (`repr`) are equal in every process.
        answers: the answers.
        read_files: files on whose contents the records also depend.
    """
    digest = hashlib.sha256(repr(settings).encode())
    for epoch in (answers, *answers.further_epochs):
        for row in epoch.read_rows():
            digest.update(row if isinstance(row, bytes) else repr(row).encode())
    for read_file in read_files:
        digest.update(read_content(read_file))
    return file.with_name(f".{file.name}-{digest.hexdigest()[:_DIGEST_LENGTH]}.part")


def count_kept_records(partial_file: Path) -> int:
    """Return the number of scored answers in a partial file. A last line that was cut off does not count."""
    return sum(1 for _ in _read_complete_lines(partial_file)) if partial_file.exists() else 0


def append_record_batches(partial_file: Path, batches: Iterable[RecordBatch]) -> RunTotals:
    """Append scored answers to the file of an unfinished command, and return the totals of all in the file.

    Each batch is in the file before the next batch is made.

    Raises:
        InputError: the file cannot be written, or its records cannot be read.
    """
    with raise_write_errors_as_input_errors(partial_file):
        partial_file.parent.mkdir(parents=True, exist_ok=True)
        with partial_file.open("ab") as file:
            file.truncate(sum(map(len, _read_complete_lines(partial_file))))
    totals = RunTotals.from_records(read_records(partial_file))
    for lines, batch_totals in batches:
        with raise_write_errors_as_input_errors(partial_file), partial_file.open("ab") as file:
            file.write(lines)
        totals.add_totals_of_later_records(batch_totals)
    return totals


def _read_complete_lines(file: Path) -> Iterator[bytes]:
    """Yield the lines of a file. A last line that was cut off is left out."""
    with file.open("rb") as lines:
        yield from (line for line in lines if line.endswith(b"\n"))


def publish_records(partial_file: Path, file: Path, totals: RunTotals) -> None:
    """Copy the complete records of a partial file to their final file.

    If they are the records of a whole run (in the file `RECORDS`), also write ``summary.json`` beside them.
    The partial file is kept until `remove_partial_files`.

    Raises:
        InputError: the files cannot be written.
    """
    if file.name == RECORDS:
        write_files_atomically({file.with_name(SUMMARY): format_summary(totals, {}, ())})
    new_file = partial_file.with_suffix(".new")
    with raise_write_errors_as_input_errors(file):
        new_file.unlink(missing_ok=True)
        try:
            os.link(partial_file, new_file)
        except OSError:  # the file system supports no hard links
            shutil.copyfile(partial_file, new_file)
        new_file.replace(file)
        # after an interrupted command, both names may be links to one file; then `replace` did nothing
        new_file.unlink(missing_ok=True)


def remove_partial_files(file: Path) -> None:
    """Remove all partial files (records of interrupted commands) beside a file of records.

    Partial files of other answers or settings are removed, too.

    Raises:
        InputError: a file cannot be removed.
    """
    for partial_file in file.parent.glob(f".{file.name}-*.part"):
        with raise_write_errors_as_input_errors(partial_file):
            partial_file.unlink(missing_ok=True)
