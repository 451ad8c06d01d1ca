"""Files of users: find them, read them line by line, write them as a whole; make their names safe to show."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import stat
import sys
import tempfile
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from eai.base.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from filelock import BaseFileLock

_HELD = ".held"
"""End of the name of a file whose presence is a lock, on file systems without locks."""

MAX_UNPACKED = 32_000_000
"""Number of bytes to which a compressed file of answers may unpack, whatever its size."""

UNPACKED_PER_BYTE = 50
"""Number of further bytes to which it may unpack, for each byte of its own."""

LOCK_FILE = "answers.lock"
"""Name of the file that a process holds in the folder where it works."""


def require_file(path: Path) -> None:
    """Refuse a device, a socket or a named pipe. Reading one may never end.

    A pipe that the shell has opened is read: ``/dev/stdin``, or ``<(...)``, which is ``/dev/fd/N``.

    Raises:
        InputError: the path is neither a file nor such a pipe. A path where nothing is passes.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        return  # who opens the file says why it cannot be read
    is_of_shell = stat.S_ISFIFO(mode) and _DESCRIPTOR.match(str(path)) is not None
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode) or is_of_shell):
        kind = next((name for is_kind, name in _ENDLESS if is_kind(mode)), "no regular file")
        raise InputError(f"{path}: is {kind}; give a file, or pipe it into /dev/stdin")


_DESCRIPTOR = re.compile(r"/dev/stdin$|/dev/fd/\d+$|/proc/(self|\d+)/fd/\d+$")
_ENDLESS = (
    (stat.S_ISFIFO, "a named pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


Content: TypeAlias = str | bytes | Iterable[str] | Iterable[bytes]
"""The content of a file: all of it, or its pieces."""

_UNSHOWN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Categories of characters that move a cursor, turn text around, or are none, such as lone surrogates."""


def read_toml(file: Path) -> dict[str, Any]:
    """The tables of a file.

    Raises:
        InputError: it cannot be read, or is no TOML.
    """
    content = read_content(file)
    try:
        return parse_toml(content.decode())
    except (ValueError, RecursionError) as error:  # also a number of too many digits, and too deep a list
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


def read_content(path: Path) -> bytes:
    """The bytes of a file.

    Raises:
        InputError: it cannot be read.
    """
    require_file(path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error


def number_lines(content: bytes) -> Iterator[tuple[int, bytes]]:
    """The lines of JSONL that are not blank, numbered from 1.

    Only a line feed ends one: JSON may hold what else ends lines of text, such as U+2028, in its strings.
    """
    return ((number, line) for number, line in enumerate(content.split(b"\n"), 1) if line.strip())


def escape_unprintable(text: str) -> str:
    """A text as it may be shown anywhere: what controls a terminal is escaped, but for lines and tabs."""
    return "".join(
        c if c in "\n\t" or unicodedata.category(c) not in _UNSHOWN else ascii(c)[1:-1] for c in text
    )


def to_file_name(name: str) -> str:
    """Return a name, such as a model's, for use in file names. Unsafe characters become underscores.

    Raises:
        InputError: the name would be empty or consist of dots.
    """
    plain = re.sub(r"[^\w.-]+", "_", name)
    if not plain.strip("."):
        raise InputError(f"{name!r}: expected a name that files can be named after")
    return plain


@contextlib.contextmanager
def convert_write_errors(place: Path) -> Iterator[None]:
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
            with convert_write_errors(path):
                path.parent.mkdir(parents=True, exist_ok=True)
                is_device = path.exists() and not (path.is_file() or path.is_dir())
                part = path if is_device else path.resolve().with_name(f".{secrets.token_hex(8)}.part")
                if not is_device:
                    parts[part] = path.resolve()
                with part.open("wb") as file:
                    file.writelines(_encoded(content))
        for part, path in parts.items():
            with convert_write_errors(path):
                part.replace(path)
    finally:
        for part in parts:
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def _encoded(content: Content) -> Iterator[bytes]:
    for piece in (content,) if isinstance(content, str | bytes) else content:
        yield piece if isinstance(piece, bytes) else piece.encode("utf-8", "backslashreplace")


def make_lock(file: Path) -> tuple[Path, BaseFileLock]:
    """Return a lock, and the file by which processes see that it is held.

    A file system may have no locks, as some of networks have none. There the lock is the presence of another
    file, which stays if the process is killed.

    Args:
        file: the file to lock, in a folder that is there.

    Raises:
        OSError: the folder cannot be written to.
    """
    from filelock import FileLock, SoftFileLock

    if _has_locks(file.parent):
        return file, FileLock(file)
    file = file.with_name(f"{file.name}{_HELD}")
    return file, SoftFileLock(file)


def _has_locks(folder: Path) -> bool:
    try:
        import fcntl
    except ImportError:  # Windows, which locks in another way
        return True
    with tempfile.TemporaryFile(dir=folder) as probe:
        try:
            fcntl.flock(probe, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:  # nobody else has this file
            return False
    return True


def stale_lock_hint(file: Path) -> str:
    """Return the end of a message: what to do about a lock that a killed process may have left."""
    return f"; if no process is, delete {file}" if file.name.endswith(_HELD) else ""


@contextlib.contextmanager
def lock_run_folder(folder: Path) -> Iterator[None]:
    """Keeps other processes out of the folder of a run during the block; the folder is made if need be.

    Raises:
        InputError: another process is working there, or the folder cannot be made.
    """
    from filelock import Timeout

    file = folder / LOCK_FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, lock = make_lock(file)
        lock.acquire(timeout=0)
    except Timeout as error:
        hint = f"wait for its end, or give another --out{stale_lock_hint(file)}"
        raise InputError(f"{folder}: another process is running there; {hint}") from error
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error
    try:
        yield
    finally:
        lock.release()
