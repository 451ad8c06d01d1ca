"""Files of users: found, read line by line, written as a whole; and their names, made safe to show.

Parquet is for those alone whose answers or tables are so many; what reads it is an extra.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, TypeAlias

from eai.errors import InputError, needing

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROWS = 1024
"""How many rows of a Parquet file are read at a time."""

LOCK = "answers.lock"
"""Name of the file that a process holds in the folder where it works."""


def parquet() -> Any:
    """Return the library for Parquet files: ``pyarrow.parquet``.

    Raises:
        EaiError: pyarrow is not installed.
    """
    with needing("analysis", "Parquet needs"):
        import pyarrow.parquet
    return pyarrow.parquet


def read_columns(path: Path, names: Sequence[str], also: Sequence[str] = ()) -> Iterator[dict[str, object]]:
    """The rows of a Parquet file, each with these columns; the file is never in memory as a whole.

    Args:
        path: the file.
        names: the columns that it must have.
        also: those that rows have where it has them.

    Raises:
        EaiError: pyarrow is not installed.
        InputError: the file cannot be read, or has no such column.
    """
    reader = parquet()
    try:
        with reader.ParquetFile(path) as file:
            there = file.schema_arrow.names
            for name in names:
                if name not in there:
                    raise InputError(f'{path}: the column "{name}" is missing')
            for batch in file.iter_batches(ROWS, columns=[*names, *(name for name in also if name in there)]):
                yield from batch.to_pylist()
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: expected a Parquet file ({str(error).splitlines()[0]})") from error


Content: TypeAlias = str | bytes | Iterable[str] | Iterable[bytes]
"""The content of a file: all of it, or its pieces."""

_UNSHOWN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Categories of characters that move a cursor, turn text around, or are none, such as lone surrogates."""


def read_toml(file: Path) -> dict[str, Any]:
    """The tables of a file.

    Raises:
        InputError: it cannot be read, or is no TOML.
    """
    content = content_of(file)
    try:
        return parse_toml(content.decode())
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{file}: expected TOML; {error}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """The tables of a text; the library is the standard one's, or its twin for Python 3.10."""
    return tomllib.loads(text)


def files_below(folder: Path, *patterns: str) -> list[Path]:
    """The files below a folder whose names match, sorted; no pipes or devices, which may never end.

    Links to folders are followed, each folder once.
    """
    found: list[Path] = []
    seen: set[str] = set()
    for place, folders, names in os.walk(folder, followlinks=True):
        folders.sort()
        real = os.path.realpath(place)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        found += [Path(place, name) for name in names if any(fnmatch(name, each) for each in patterns)]
    return sorted(file for file in found if file.is_file())


def content_of(path: Path) -> bytes:
    """The bytes of a file.

    Raises:
        InputError: it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error


def lines(content: bytes) -> Iterator[tuple[int, bytes]]:
    """The lines of JSONL that are not blank, numbered from 1.

    Only a line feed ends one: JSON may hold what else ends lines of text, such as U+2028, in its strings.
    """
    return ((number, line) for number, line in enumerate(content.split(b"\n"), 1) if line.strip())


def printable(text: str) -> str:
    """A text as it may be shown anywhere: what controls a terminal is escaped, but for lines and tabs."""
    return "".join(
        c if c in "\n\t" or unicodedata.category(c) not in _UNSHOWN else ascii(c)[1:-1] for c in text
    )


@contextlib.contextmanager
def writing_to(place: Path) -> Iterator[None]:
    """Within it, files are written to a place.

    Raises:
        InputError: it cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"{place}: cannot be written ({error.strerror})") from error


def write_whole(contents: Mapping[Path, Content]) -> None:
    """Write files, each as a whole: under its name there is the old file or the new one, never a part.

    Lone surrogates are written as their escapes, which JSON reads as themselves.

    Raises:
        InputError: one cannot be written; none of them has changed then, but where a name cannot be taken
            over.
    """
    parts: dict[Path, Path] = {}
    try:
        for path, content in contents.items():
            with writing_to(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                is_device = path.exists() and not (path.is_file() or path.is_dir())
                part = path if is_device else path.resolve().with_name(f".{secrets.token_hex(8)}.part")
                if not is_device:
                    parts[part] = path.resolve()
                with part.open("wb") as file:
                    file.writelines(_encoded(content))
        for part, path in parts.items():
            with writing_to(path):
                part.replace(path)
    finally:
        for part in parts:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def _encoded(content: Content) -> Iterator[bytes]:
    for piece in (content,) if isinstance(content, str | bytes) else content:
        yield piece if isinstance(piece, bytes) else piece.encode("utf-8", "backslashreplace")


@contextlib.contextmanager
def sole_run(folder: Path) -> Iterator[None]:
    """Keeps other processes out of the folder of a run during the block; the folder is made if need be.

    Raises:
        InputError: another process is working there, or the folder cannot be made.
    """
    from filelock import FileLock, Timeout

    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / LOCK, timeout=0)
        lock.acquire()
    except Timeout as error:
        hint = "wait for its end, or give another --out"
        raise InputError(f"{folder}: another process is running there; {hint}") from error
    except NotImplementedError:  # a file system without locks
        yield
        return
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error
    try:
        yield
    finally:
        lock.release()
