"""The local data store: a folder with one file for each pack (a converted data set).

A pack is a zip. Its first member, `manifest.json`, lists the schema, the archives that the pack was made
from, and the SHA-256 of every other member. Members are read and checked on request. A new pack is written
under another name in the same folder and then moved into place, so that a reader sees only complete packs.
Progress is reported by a callback, so that a command line can draw a bar.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias

import platformdirs

from eai.base.errors import DataError

FOLDER_VARIABLE = "EAI_DATA_DIR"
"""Environment variable that names the folder of packs (converted data sets)."""

SCHEMA = 1
"""Version of the format of packs (converted data sets).

It is part of the file name, so that versions of eai can share a folder.
"""

_MANIFEST = "manifest.json"
_EPOCH = (1980, 1, 1, 0, 0, 0)
_UNREADABLE = (OSError, EOFError, KeyError, RuntimeError, ValueError, zipfile.BadZipFile, zlib.error)
_REPAIR = "run `eai data fetch --force`"

FetchStage: TypeAlias = Literal["waiting for", "fetching", "converting"]
"""A stage in which a pack (a converted data set) is made, such as the download of its archive."""

ReportProgress: TypeAlias = Callable[[FetchStage, str, int, int], None]
"""Callback that is called with each step of progress, from the calling thread.

Its arguments are the stage, the name of the file or data set, the number of units done, and the total number
of units. Units are bytes of a download, or tasks or files of a conversion. The total is 0 while this process
waits for another process that converts the data set.
"""


def ignore_progress(stage: FetchStage, subject: str, done: int, total: int) -> None:
    """Ignore a report of progress. Callers without a progress bar pass this function."""


def default_folder() -> Path:
    """Return the folder that `EAI_DATA_DIR` names, or else `eai` in the user's cache folder."""
    configured = os.environ.get(FOLDER_VARIABLE)
    return Path(configured) if configured else platformdirs.user_cache_path("eai") / "data"


@dataclass(frozen=True, slots=True)
class PackFile:
    """A pack (a converted data set) on disk, with its manifest.

    Attributes:
        path: the file.
        archives: SHA-256 of each archive (`name==version`) from which the pack was converted.
        members: SHA-256 of the content of each member of the zip, by the member's name.
    """

    path: Path
    archives: Mapping[str, str]
    members: Mapping[str, str]

    @property
    def sha256(self) -> str:
        """One SHA-256 for the contents of all files (members) of the pack, a converted data set.

        The digest does not depend on compression.
        """
        lines = "".join(f"{name} {digest}\n" for name, digest in sorted(self.members.items()))
        return hashlib.sha256(lines.encode()).hexdigest()

    def read_member(self, member: str) -> bytes:
        """Read and verify a file (member) of the pack, which is a zip with a converted data set.

        Raises:
            DataError: the member is absent or damaged.
        """
        expected = self.members.get(member)
        if expected is None:
            raise DataError(f"{self.path}: has no member {member}; {_REPAIR}")
        content = _read_zip_member(self.path, member)
        if hashlib.sha256(content).hexdigest() != expected:
            raise DataError(f"{self.path}: {member} is damaged (its SHA-256 differs); {_REPAIR}")
        return content

    def read_json(self, member: str) -> Any:
        """Read, verify and parse a JSON file (member) of the pack, a zip with a converted data set.

        Raises:
            DataError: the member is absent or damaged.
        """
        return json.loads(self.read_member(member))


@dataclass(frozen=True, slots=True)
class DataPackStore:
    """A folder of packs (converted data sets)."""

    folder: Path = field(default_factory=default_folder)

    def get_pack_path(self, pack: str) -> Path:
        """Return the path of the file of a pack (a converted data set), even if the file does not exist."""
        return self.folder / f"{pack}.{SCHEMA}.zip"

    def has_pack(self, pack: str) -> bool:
        """Whether the folder has a file for the pack (a converted data set). The file may be damaged."""
        return self.get_pack_path(pack).is_file()

    def open_pack(self, pack: str) -> PackFile:
        """Open a pack (an archive with the files of a data set), given its name.

        Raises:
            DataError: the pack has not been fetched, or is damaged.
        """
        path = self.get_pack_path(pack)
        if not self.has_pack(pack):
            raise DataError(
                f"{path}: no such data; run `eai data fetch`, or set EAI_DATA_DIR to a fetched folder"
            )
        try:
            values = json.loads(_read_zip_member(path, _MANIFEST))
            file = PackFile(path, dict(values["archives"]), dict(values["members"]))
            digest, schema = values["sha256"], values["schema"]
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(f"{path}: is damaged (unreadable manifest); {_REPAIR}") from error
        if schema != SCHEMA or digest != file.sha256:
            raise DataError(f"{path}: is damaged (its manifest contradicts itself); {_REPAIR}")
        return file

    def write_pack(
        self,
        pack_name: str,
        sha256_by_source_archive: Mapping[str, str],
        content_by_member: Mapping[str, bytes],
    ) -> PackFile:
        """Write a pack (a converted data set). An older file of the pack is replaced as a whole.

        Raises:
            DataError: the folder cannot be written to.
        """
        path = self.get_pack_path(pack_name)
        digests = {name: hashlib.sha256(content).hexdigest() for name, content in content_by_member.items()}
        file = PackFile(path, dict(sha256_by_source_archive), digests)
        partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _write_pack_zip(partial, file, content_by_member)
            partial.replace(path)
        except OSError as error:
            raise make_unwritable_error(self.folder, error) from error
        finally:
            with contextlib.suppress(OSError):
                partial.unlink()
        return file

    def remove_partial_packs(self) -> None:
        """Remove partly written files of interrupted processes. The caller must hold the folder's lock."""
        for partial in self.folder.glob(".*.partial"):
            partial.unlink(missing_ok=True)


def make_unwritable_error(folder: Path, error: OSError) -> DataError:
    """Return the error to raise for a data folder that cannot be written to."""
    reason = error.strerror or str(error)
    return DataError(f"{folder}: cannot be written to ({reason}); set EAI_DATA_DIR to a writable folder")


def _read_zip_member(path: Path, member: str) -> bytes:
    try:
        with zipfile.ZipFile(path) as archive:
            return archive.read(member)
    except _UNREADABLE as error:
        raise DataError(f"{path}: is damaged ({member} cannot be read: {error}); {_REPAIR}") from error


def _write_pack_zip(path: Path, pack: PackFile, members: Mapping[str, bytes]) -> None:
    """Write a pack (a converted data set) as a zip, and sync the zip to disk.

    Otherwise a power cut could leave an empty file.

    All members have the same fixed date, so that equal contents give equal files.
    """
    header = {"schema": SCHEMA, "sha256": pack.sha256, "archives": pack.archives, "members": pack.members}
    with path.open("wb") as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            archive.writestr(_make_zip_entry(_MANIFEST), json.dumps(header, indent=1).encode())
            for name, content in members.items():
                archive.writestr(_make_zip_entry(name), content)
        file.flush()
        os.fsync(file.fileno())


def _make_zip_entry(name: str) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name, _EPOCH)
    entry.compress_type = zipfile.ZIP_DEFLATED
    return entry
