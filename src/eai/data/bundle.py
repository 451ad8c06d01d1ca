"""The files inside a downloaded archive, read in place: a wheel is never unpacked to disk.

A wheel is a zip, a source distribution a gzipped tar with one top folder. An unpacked wheel is a folder
whose `RECORD` lists the digest of every file; each file is checked against it when read.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import tarfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from eai.errors import DataError


class Bundle(Protocol):
    """Named files; paths use `/` and, in a source distribution, leave out the top folder."""

    def names(self) -> tuple[str, ...]:
        """All files, in the order of the archive."""

    def read(self, path: str) -> bytes:
        """The content of one file.

        Raises:
            DataError: it is not there, or damaged.
        """


@dataclass(frozen=True, slots=True)
class _ZipBundle:
    """A wheel."""

    archive: zipfile.ZipFile

    def names(self) -> tuple[str, ...]:
        """All files, in the order of the archive."""
        return tuple(self.archive.namelist())

    def read(self, path: str) -> bytes:
        """The content of one file; DataError when absent or damaged."""
        try:
            return self.archive.read(path)
        except (KeyError, zipfile.BadZipFile) as error:
            raise DataError(f"{self.archive.filename}: no readable file {path} ({error})") from error


@dataclass(frozen=True, slots=True)
class _TarBundle:
    """A source distribution, read whole, since a gzipped tar has no index; these are small."""

    path: Path
    files: dict[str, bytes]

    def names(self) -> tuple[str, ...]:
        """All files, in the order of the archive."""
        return tuple(self.files)

    def read(self, path: str) -> bytes:
        """The content of one file; DataError when absent."""
        try:
            return self.files[path]
        except KeyError as error:
            raise DataError(f"{self.path}: no file {path}") from error


@dataclass(frozen=True, slots=True)
class _FolderBundle:
    """An unpacked wheel; `digests` maps each path to its SHA-256 as in `RECORD`."""

    folder: Path
    digests: dict[str, str]

    def names(self) -> tuple[str, ...]:
        """All files that `RECORD` gives a digest for, in its order."""
        return tuple(self.digests)

    def read(self, path: str) -> bytes:
        """The content of one file; DataError when absent or unlike its digest."""
        try:
            content = (self.folder / path).read_bytes()
        except OSError as error:
            raise DataError(f"{self.folder}: no readable file {path} ({error.strerror})") from error
        if self.digests.get(path) != _record_digest(content):
            raise DataError(f"{self.folder / path}: content differs from the published file")
        return content


def _record_digest(content: bytes) -> str:
    """SHA-256 as a wheel's `RECORD` writes it: URL-safe base 64 without padding."""
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def read_record(folder: Path) -> dict[str, str]:
    """Path -> digest of the published files of an unpacked (or installed) wheel.

    Lines that an installer adds (its own metadata, byte code) are left out, so that an installed package
    gives the same mapping as the unpacked wheel.
    """
    digests: dict[str, str] = {}
    for record in sorted(folder.glob("*.dist-info/RECORD")):
        for path, digest, _size in csv.reader(record.read_text(encoding="utf-8").splitlines()):
            own = ".dist-info/" in path or path.endswith(".pyc") or path.startswith("..")
            if digest.startswith("sha256=") and not own:
                digests[path] = digest.removeprefix("sha256=")
    return digests


def record_sha256(digests: dict[str, str]) -> str:
    """One SHA-256 for all files of a wheel, to pin an unpacked one by."""
    lines = "".join(f"{path},{digest}\n" for path, digest in sorted(digests.items()))
    return hashlib.sha256(lines.encode()).hexdigest()


@contextmanager
def open_bundle(path: Path) -> Iterator[Bundle]:
    """Open an archive or an unpacked wheel whose digest has been verified.

    Raises:
        DataError: it cannot be read as an archive.
    """
    if path.is_dir():
        yield _FolderBundle(path, read_record(path))
    elif path.suffix == ".whl":
        try:
            archive = zipfile.ZipFile(path)
        except (OSError, zipfile.BadZipFile) as error:
            raise DataError(f"{path}: not a readable wheel ({error})") from error
        with archive:
            yield _ZipBundle(archive)
    else:
        yield _TarBundle(path, _tar_files(path))


def _tar_files(path: Path) -> dict[str, bytes]:
    files: dict[str, bytes] = {}
    try:
        with tarfile.open(path, "r:gz") as archive:
            for member in archive:
                content = archive.extractfile(member) if member.isfile() else None
                if content is not None:
                    files[member.name.partition("/")[2]] = content.read()
    except (OSError, tarfile.TarError, EOFError) as error:
        raise DataError(f"{path}: not a readable source distribution ({error})") from error
    return files
