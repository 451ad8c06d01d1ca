"""Read users' files, write files as a whole, and make names and texts safe for files and terminals."""

from __future__ import annotations

import contextlib
import json
import os
import re
import secrets
import stat
import sys
import tempfile
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatch
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from filelock import BaseFileLock

_LOCK_SUFFIX = ".held"
"""Suffix of a file whose existence locks another file, on file systems that have no file locks."""

MAX_UNPACKED = 32_000_000
"""Maximum size in bytes of an unpacked answer file.

`UNPACKED_PER_BYTE` raises this limit for large compressed files.
"""

UNPACKED_PER_BYTE = 50
"""Number of bytes added to `MAX_UNPACKED` for each byte of a compressed answer file."""

_GZIP = b"\x1f\x8b"
"""First bytes of a file that gzip wrote."""

LOCK_FILE = "answers.lock"
"""Usual name of the file that a process locks in its output folder, to keep other processes out."""


def require_file(path: Path) -> None:
    """Raise if a path is a device, a socket or a named pipe, since reading one may never end.

    A pipe that the shell has opened is accepted: ``/dev/stdin``, or ``<(...)``, which is ``/dev/fd/N``.

    Raises:
        InputError: the path exists, but is no file and no pipe that the shell has opened.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        return  # the caller tries to read the path, and reports the error
    is_of_shell = stat.S_ISFIFO(mode) and _DESCRIPTOR.match(str(path)) is not None
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode) or is_of_shell):
        kind = next((name for is_kind, name in _ENDLESS if is_kind(mode)), "no regular file")
        raise InputError(f"{path}: is {kind}; give a file, or give /dev/stdin and pipe the content into eai")


_DESCRIPTOR = re.compile(r"/dev/stdin$|/dev/fd/\d+$|/proc/(self|\d+)/fd/\d+$")
_ENDLESS = (
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


Content: TypeAlias = str | bytes | Iterable[str] | Iterable[bytes]
"""The content of a file: one text or byte string, or an iterable of its pieces."""

_UNSAFE_CATEGORIES = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Unicode categories that can garble a terminal: controls, formats, separators, lone surrogates."""


def read_toml(file: Path) -> dict[str, Any]:
    """Read a TOML file as a mapping.

    Raises:
        InputError: the file cannot be read, or is not TOML.
    """
    content = read_content(file)
    try:
        return parse_toml(content.decode())
    except (ValueError, RecursionError) as error:  # tables nested too deep raise RecursionError
        raise InputError(f"{file}: expected TOML; {error}") from error


def parse_toml(text: str) -> dict[str, Any]:
    """Parse a TOML text to a mapping, by `tomllib` or, in Python 3.10, by `tomli`."""
    return tomllib.loads(text)


def format_toml_text(text: str) -> str:
    """Return a text as a TOML string, in quotation marks."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def find_files_below(folder: Path, *patterns: str) -> list[Path]:
    """Return the files below a folder whose names match a pattern, sorted by path.

    Pipes and devices are left out, since reading one may never end. Links to folders are followed, but each
    folder is visited only once.
    """
    files: list[Path] = []
    seen_folders: set[str] = set()
    for parent, folders, names in os.walk(folder, followlinks=True):
        folders.sort()
        real_path = os.path.realpath(parent)
        if real_path in seen_folders:
            folders.clear()
            continue
        seen_folders.add(real_path)
        files += [Path(parent, name) for name in names if any(fnmatch(name, pattern) for pattern in patterns)]
    return sorted(file for file in files if file.is_file())


def read_content(path: Path) -> bytes:
    """Read the bytes of a file.

    Raises:
        InputError: the file cannot be read.
    """
    require_file(path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error


def decode_text(path: Path, content: bytes) -> str:
    """Return the text of a file in UTF-8, without a byte order mark.

    Raises:
        InputError: the content is not in UTF-8.
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: expected a text in UTF-8 ({error})") from error


def parse_json(path: Path, content: bytes, line: int | None = None) -> object:
    """Parse JSON of a user's file. Control characters in texts are accepted.

    Args:
        path: the file, for messages.
        content: the JSON text.
        line: number of the line of the file, from 1, if the content is a single line; None for a whole file.

    Raises:
        InputError: the content is not JSON, or a member of an object occurs twice; the message has the place.
    """
    try:
        value: object = json.loads(content, strict=False, object_pairs_hook=make_dict_refusing_repeated_keys)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno + (line or 1) - 1}, column {error.colno}"
        raise InputError(f"{path}, {where}: expected JSON ({error.msg})") from error
    except (InputError, ValueError, RecursionError) as error:
        where = "" if line is None else f", line {line}"
        problem = str(error) if isinstance(error, InputError) else f"expected JSON in UTF-8 ({error})"
        if content.startswith(_GZIP):
            problem = "expected JSON, found a compressed file; unpack it with gunzip"
        raise InputError(f"{path}{where}: {problem}") from error
    return value


def make_dict_refusing_repeated_keys(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """Return a JSON object's members; `json.loads` takes this function as `object_pairs_hook`.

    Raises:
        InputError: a member occurs twice.
    """
    members: dict[str, object] = {}
    for key, value in pairs:
        if key in members:
            raise InputError(f"the member {key!r} occurs twice in a JSON object; keep one")
        members[key] = value
    return members


def number_lines(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Return the nonblank lines of a JSON Lines text with their line numbers, counted from 1.

    Only a line feed ends a line, because JSON strings may contain other line separators, such as U+2028.
    Lines are split off one by one, so that not all of them are in memory.
    """
    lines = enumerate(BytesIO(content), 1)
    return ((number, line.removesuffix(b"\n")) for number, line in lines if line.strip())


def escape_unprintable(text: str) -> str:
    """Escape the characters of a text that could control a terminal, except line feeds and tabs."""
    return "".join(
        c if c in "\n\t" or unicodedata.category(c) not in _UNSAFE_CATEGORIES else ascii(c)[1:-1]
        for c in text
    )


def to_file_name(name: str) -> str:
    """Convert a name, such as a model's, to a part of a file name. Unsafe characters become underscores.

    Raises:
        InputError: the result would be empty or consist of dots.
    """
    plain = re.sub(r"[^\w.-]+", "_", name)
    if not plain.strip("."):
        raise InputError(f"no file can be named after {name!r}: use a name with letters or digits")
    return plain


def to_model_name(file_name: str) -> str:
    """Return the name of a model, given its name in file names.

    Names of built-in models contain a slash: ``eai/noisy`` for ``eai_noisy``.
    """
    return f"eai/{file_name[len('eai_') :]}" if file_name.startswith("eai_") else file_name


@contextlib.contextmanager
def raise_write_errors_as_input_errors(path: Path) -> Iterator[None]:
    """Convert an OSError that the block raises to an InputError that names the path.

    Raises:
        InputError: the path cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error


def write_files_atomically(contents: Mapping[Path, Content]) -> None:
    """Write files, each as a whole: a reader sees the old file or the new file, but no half-written file.

    Lone surrogates are written as escapes, which JSON reads back as lone surrogates.

    Raises:
        InputError: a file cannot be written. In this case no file has changed, or, if the error occurred
            while files were replaced, some files are old and some are new.
    """
    partial_files: dict[Path, Path] = {}
    try:
        for path, content in contents.items():
            with raise_write_errors_as_input_errors(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                is_device = path.exists() and not (path.is_file() or path.is_dir())
                partial_file = (
                    path if is_device else path.resolve().with_name(f".{secrets.token_hex(8)}.part")
                )
                if not is_device:
                    partial_files[partial_file] = path.resolve()
                with partial_file.open("wb") as file:
                    file.writelines(_encode_content(content))
        for partial_file, path in partial_files.items():
            with raise_write_errors_as_input_errors(path):
                partial_file.replace(path)
    finally:
        for partial_file in partial_files:
            with contextlib.suppress(OSError):
                partial_file.unlink(missing_ok=True)


def _encode_content(content: Content) -> Iterator[bytes]:
    for piece in (content,) if isinstance(content, str | bytes) else content:
        yield piece if isinstance(piece, bytes) else piece.encode("utf-8", "backslashreplace")


def make_file_lock(file: Path) -> tuple[Path, BaseFileLock]:
    """Return a lock for a file, and the path of the file by which processes lock it.

    Some network file systems have no file locks. There, the existence of another file is the lock. This other
    file is left over if the process is killed.

    Args:
        file: the file to lock, in an existing folder.

    Raises:
        OSError: the folder cannot be written to.
    """
    from filelock import FileLock, SoftFileLock

    if _supports_file_locks(file.parent):
        return file, FileLock(file)
    file = file.with_name(f"{file.name}{_LOCK_SUFFIX}")
    return file, SoftFileLock(file)


def _supports_file_locks(folder: Path) -> bool:
    try:
        import fcntl
    except ImportError:  # only Windows lacks `fcntl`; it locks files by other means
        return True
    with tempfile.TemporaryFile(dir=folder) as probe:
        try:
            fcntl.flock(probe, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            # No other process knows this new file. So the error means that the file system has no locks.
            return False
    return True


def make_stale_lock_hint(file: Path) -> str:
    """Return a hint on how to remove the lock file of a killed process; "" if the file is no lock file."""
    return f"; if no process is running there, delete {file}" if file.name.endswith(_LOCK_SUFFIX) else ""


@contextlib.contextmanager
def lock_run_folder(folder: Path, lock_file: str = LOCK_FILE) -> Iterator[None]:
    """Keep other processes out of the folder of a run during the block. A missing folder is created.

    Args:
        folder: the folder.
        lock_file: name of the lock file in the folder; jobs with different lock files may run at once.

    Raises:
        InputError: another process uses the folder, or the folder cannot be created.
    """
    from filelock import Timeout

    file = folder / lock_file
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, lock = make_file_lock(file)
        lock.acquire(timeout=0)
    except Timeout as error:
        hint = f"wait for its end, or give another --out{make_stale_lock_hint(file)}"
        raise InputError(f"{folder}: another process is writing to this folder; {hint}") from error
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error
    try:
        yield
    finally:
        lock.release()
