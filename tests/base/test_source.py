from __future__ import annotations

import dataclasses
import importlib.util
import shutil
import sys
import threading
import zipfile
from pathlib import Path

import pytest

from benchmarks.synthetic import build_sdist
from eai.base import source
from eai.base.errors import DataError
from eai.base.source import (
    PackageArchive,
    download_archive,
    find_command_that_runs_pip,
    find_verified_archive,
    open_archive_files,
)
from eai.base.store import ignore_progress
from eai.benchmarks.reference_wheel import EAI_EVAL

PIP = (sys.executable, "-m", "pip")


@pytest.fixture
def target(tmp_path: Path) -> Path:
    folder = tmp_path / "download"
    folder.mkdir()
    return folder


def test_pip_downloads_a_wheel_from_the_configured_index(wheel: PackageArchive, target: Path) -> None:
    steps: list[tuple[str, str, int, int]] = []
    path = download_archive(wheel, target, lambda *step: steps.append(step), PIP)
    assert path.read_bytes()[:2] == b"PK"
    assert steps[-1] == ("fetching", wheel.filename, wheel.size, wheel.size)
    assert all(0 <= done <= total for _, _, done, total in steps)


def test_a_source_distribution_is_downloaded_without_running_it(index: Path, target: Path) -> None:
    witness = target / "ran"
    archive = build_sdist(index, witness)
    path = download_archive(archive, target, ignore_progress, PIP)
    with open_archive_files(path) as bundle:
        assert bundle.read("problems/one.bddl") == b"(define)"
        assert set(bundle.names) == {"PKG-INFO", "setup.py", "problems/one.bddl"}
        with pytest.raises(DataError, match="no file absent"):
            bundle.read("absent")
    assert not witness.exists()


def test_a_file_that_differs_from_the_published_one_is_refused(wheel: PackageArchive, target: Path) -> None:
    pinned = dataclasses.replace(wheel, sha256="0" * 64)
    with pytest.raises(DataError, match=r"cannot download madeup-eval==1\.0 .*--from") as caught:
        download_archive(pinned, target, ignore_progress, PIP)
    assert "\n" not in str(caught.value)


def test_the_error_for_a_failed_download_says_what_to_do(index: Path, target: Path) -> None:
    absent = PackageArchive("madeup-eval", "1.0", "madeup_eval-1.0-py3-none-any.whl", "0" * 64, 1)
    with pytest.raises(DataError, match=r"--from FILE.*EAI_DATA_DIR") as caught:
        download_archive(absent, target, ignore_progress, PIP)
    assert "\n" not in str(caught.value)


def test_the_error_for_a_pip_that_cannot_start_says_what_to_do(wheel: PackageArchive, target: Path) -> None:
    with pytest.raises(DataError, match=r"no-such-pip.*--from FILE"):
        download_archive(wheel, target, ignore_progress, ("no-such-pip",))


def test_an_interrupt_ends_the_download(wheel: PackageArchive, target: Path) -> None:
    def interrupt(*step: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        download_archive(wheel, target, interrupt, PIP)
    assert not (target / wheel.filename).exists()


def test_the_interpreters_own_pip_is_preferred() -> None:
    assert find_command_that_runs_pip(EAI_EVAL) == PIP


def test_uv_stands_in_for_a_missing_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(shutil, "which", lambda name: "/bin/uv" if name == "uv" else None)
    assert find_command_that_runs_pip(EAI_EVAL, "python") == (
        "/bin/uv",
        "tool",
        "run",
        "--quiet",
        "--python",
        "python",
        "pip",
    )


def test_the_error_without_pip_and_uv_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(DataError, match=r"neither pip nor uv.*--from FILE"):
        find_command_that_runs_pip(EAI_EVAL)


def test_pip_gets_the_index_of_uv(
    wheel: PackageArchive, target: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = tmp_path / "seen"
    code = f"import os; open({str(written)!r}, 'w').write(os.environ['PIP_INDEX_URL'])"
    monkeypatch.setenv("UV_DEFAULT_INDEX", "file:///mirror")
    monkeypatch.delenv("PIP_INDEX_URL", raising=False)
    with pytest.raises(DataError):
        download_archive(wheel, target, ignore_progress, (sys.executable, "-c", code))
    assert written.read_text() == "file:///mirror"


def test_an_archive_is_found_as_a_file_in_a_folder_or_unpacked(
    index: Path, wheel: PackageArchive, tmp_path: Path
) -> None:
    path = index / wheel.filename
    unpacked = tmp_path / "unpacked"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(unpacked)
    renamed = tmp_path / "renamed.whl"
    shutil.copy(path, renamed)
    assert [find_verified_archive(wheel, place) for place in (path, index, unpacked, renamed)] == [
        path,
        path,
        unpacked,
        renamed,
    ]
    (tmp_path / "empty").mkdir()
    assert find_verified_archive(wheel, tmp_path / "empty") is None
    assert find_verified_archive(build_sdist(tmp_path, tmp_path), path) is None


def test_a_changed_archive_is_refused(index: Path, wheel: PackageArchive) -> None:
    path = index / wheel.filename
    path.write_bytes(path.read_bytes() + b" ")
    with pytest.raises(DataError, match=r"not madeup-eval==1\.0 as published"):
        find_verified_archive(wheel, index)
    with pytest.raises(DataError, match="no such file or folder"):
        find_verified_archive(wheel, index / "absent")


def test_a_changed_file_of_an_unpacked_wheel_is_refused(
    index: Path, wheel: PackageArchive, tmp_path: Path
) -> None:
    unpacked = tmp_path / "unpacked"
    with zipfile.ZipFile(index / wheel.filename) as archive:
        archive.extractall(unpacked)
    victim = unpacked / "virtualhome_eval/resources/vocabulary.json"
    victim.write_bytes(b"{}")
    with open_archive_files(unpacked) as bundle:
        with pytest.raises(DataError, match="differs from the published file"):
            bundle.read("virtualhome_eval/resources/vocabulary.json")
        victim.unlink()
        with pytest.raises(DataError, match="no readable file"):
            bundle.read("virtualhome_eval/resources/vocabulary.json")
    record = unpacked / "madeup_eval-1.0.dist-info" / "RECORD"
    record.write_text(record.read_text().replace("sha256=", "sha256=A"))
    with pytest.raises(DataError, match="as published"):
        find_verified_archive(wheel, unpacked)


@pytest.mark.parametrize("name", ["broken.whl", "broken.tar.gz"])
def test_a_file_that_is_not_an_archive_is_an_error(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(b"nothing of the kind")
    with pytest.raises(DataError, match="not a readable"), open_archive_files(path):
        pass


def test_watching_a_download_survives_folders_that_come_and_go(tmp_path: Path) -> None:
    stop = threading.Event()

    def churn() -> None:
        while not stop.is_set():
            inner = tmp_path / "unpack" / "deeper"
            inner.mkdir(parents=True)
            (inner / "file").write_bytes(b"1234")
            shutil.rmtree(tmp_path / "unpack")

    thread = threading.Thread(target=churn)
    thread.start()
    try:
        assert {source._find_largest_file_size(tmp_path) for _ in range(2_000)} <= {0, 4}
    finally:
        stop.set()
        thread.join()
