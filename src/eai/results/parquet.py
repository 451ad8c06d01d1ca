"""Reads Parquet files with many answers or large tables.

It needs pyarrow, which the extra `analysis` installs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from eai.base.errors import InputError, require_extra
from eai.base.files import MAX_UNPACKED, UNPACKED_PER_BYTE, require_file

_BATCH_ROWS = 1024
"""Number of rows that are read at a time."""

_SHARED_PREFIXES = "DELTA_BYTE_ARRAY"
"""Parquet encoding that leaves out the first characters of a text if they equal those of the text before.

So a few bytes can unpack to many bytes.
"""


def import_parquet() -> Any:
    """Return the module ``pyarrow.parquet``.

    Raises:
        EaiError: pyarrow is not installed.
    """
    with require_extra("analysis", "Parquet needs"):
        import pyarrow.parquet
    return pyarrow.parquet


def read_columns(
    path: Path, required: Sequence[str], optional: Sequence[str] = ()
) -> Iterator[dict[str, object]]:
    """Yield the rows of a Parquet file with some of its columns, without loading the whole file.

    Rows whose text is stored once in the file share one copy of it in memory.

    Args:
        path: the file.
        required: the columns that the file must have.
        optional: columns that are read if the file has them.

    Raises:
        EaiError: pyarrow is not installed.
        InputError: the file cannot be read, lacks a column, or unpacks to far more bytes than it has.
    """
    reader = import_parquet()
    from pyarrow import ArrowException

    require_file(path)
    try:
        metadata = reader.read_metadata(path)
        names = metadata.schema.to_arrow_schema().names
        flat_columns = [metadata.schema.column(index).path for index in range(metadata.num_columns)]
        for name in required:
            if name not in names:
                raise InputError(f'{path}: the column "{name}" is missing')
        columns = [*required, *(name for name in optional if name in names)]
        for name in columns:
            if names.count(name) > 1:
                raise InputError(f'{path}: two columns are named "{name}"; keep one')
            if name not in flat_columns:
                raise InputError(f'{path}: the column "{name}" has lists or objects; expected single values')
        is_prefixed = _check_sizes_and_detect_prefix_compression(path, metadata, columns)
        with reader.ParquetFile(path, read_dictionary=[] if is_prefixed else columns) as file:
            for batch in file.iter_batches(1 if is_prefixed else _BATCH_ROWS, columns=columns):
                texts = [_read_column_values(batch.column(name)) for name in columns]
                yield from (dict(zip(columns, row, strict=True)) for row in zip(*texts, strict=True))
    except (OSError, ValueError, OverflowError, MemoryError, ArrowException) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise InputError(f"{path}: expected a Parquet file ({reason})") from error


def _check_sizes_and_detect_prefix_compression(path: Path, metadata: Any, columns: Sequence[str]) -> bool:
    """Raise InputError if a group of rows is too large after decompression.

    Return whether some texts are stored as a difference: without their first characters, if these equal the
    first characters of the text before. Such a text may be much larger than its bytes in the file.
    """
    limit = MAX_UNPACKED + UNPACKED_PER_BYTE * path.stat().st_size
    is_prefixed = False
    for group in map(metadata.row_group, range(metadata.num_row_groups)):
        chunks = [group.column(i) for i in range(group.num_columns)]
        wanted = [chunk for chunk in chunks if chunk.path_in_schema in columns]
        unpacked = sum(chunk.total_uncompressed_size for chunk in wanted)
        if unpacked > limit:
            expected = f"expected at most {limit:,} bytes of answers in a group of rows"
            raise InputError(f"{path}: {expected}, found {unpacked:,} bytes; write smaller groups of rows")
        is_prefixed |= any(_SHARED_PREFIXES in chunk.encodings for chunk in wanted)
    return is_prefixed


def _read_column_values(column: Any) -> list[object]:
    """Return the values of a column in a batch of rows. Equal texts that are stored once share one object."""
    if not hasattr(column, "dictionary"):
        return list(column.to_pylist())
    entries = column.dictionary.to_pylist()
    return [None if index is None else entries[index] for index in column.indices.to_pylist()]
