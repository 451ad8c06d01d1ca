"""Fetch, convert, check and open packs. A pack is an installed data package, made from published archives.

Opening an absent pack fetches it first. A distribution registers the packs of a benchmark by an entry point
of the group ``eai.packs``: a sequence of `DataPack`, under the benchmark's name. Several benchmarks may
register one pack.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from eai.base import source
from eai.base.entry_points import EntryPoint, get_entry_points
from eai.base.errors import DataError
from eai.base.files import make_file_lock, make_stale_lock_hint
from eai.base.source import PackageArchive, open_archive_files
from eai.base.store import DataPackStore, PackFile, ReportProgress, ignore_progress, make_unwritable_error
from eai.benchmarks.registry import PAPER_BENCHMARKS, list_paper_benchmarks
from eai.tasks.source import DataMistake, Source

GROUP = "eai.packs"
"""Group of the entry points by which benchmarks register their packs (data packages)."""


def _report_no_problems(store: DataPackStore) -> Iterable[str]:
    return ()


@dataclass(frozen=True, slots=True)
class DataPack:
    """A data package: one file of the data store, made from published archives. It contains member files.

    Attributes:
        name: name of the pack in `DataPackStore.open_pack`.
        archives: archives from which the pack is made.
        convert: function from the files of the archives to the files in the pack: content by name. It reports
            progress, and raises DataError. Equal archives give equal bytes.
        check: yields the problems of the pack's content. It is called when all packs can be read.
    """

    name: str
    archives: tuple[PackageArchive, ...]
    convert: Callable[..., Mapping[str, bytes]]
    check: Callable[[DataPackStore], Iterable[str]] = _report_no_problems

    @property
    def archive_digests(self) -> dict[str, str]:
        """Mapping from the requirement of each archive, such as ``bddl==3.6.0``, to its SHA-256.

        The pack's manifest records this mapping.
        """
        return {archive.pip_requirement: archive.sha256 for archive in self.archives}


@dataclass(frozen=True, slots=True)
class _DataPackStatus:
    """The status of one pack (data package), which `eai data info` prints.

    Attributes:
        pack: name of the pack.
        size: bytes on disk; 0 if the pack is absent.
        sha256: digest of the content; None if the pack is absent or damaged.
        archives: requirement of each archive, such as ``bddl==3.6.0`` -> its SHA-256.
        problem: one line that tells the user how to get the pack; None if the pack is ready.
    """

    pack: str
    size: int
    sha256: str | None
    archives: Mapping[str, str]
    problem: str | None


def find_packs(benchmarks: Iterable[str] | None = None) -> tuple[DataPack, ...]:
    """Return the registered packs (data packages) of some benchmarks, or of all benchmarks for None.

    A pack that several benchmarks share is listed once.
    """
    points = _get_entry_points()
    names = [name for name in (points if benchmarks is None else benchmarks) if name in points]
    return tuple({pack.name: pack for name in names for pack in points[name].load()}.values())


def _get_entry_points() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, PAPER_BENCHMARKS)


def open_pack(
    name: str, source: Source | None = None, *, packs: Sequence[DataPack] | None = None
) -> PackFile:
    """Open a pack (data package) by name. If it is absent, download its archives and make it.

    Other absent packs that can be made from these archives are made too.

    Args:
        name: name of the pack.
        source: the data store; the user's default store if None.
        packs: the packs that may be fetched; all registered packs if None.

    Raises:
        DataError: the pack cannot be obtained, or is damaged.
    """
    source = source or Source()
    store = source.store or DataPackStore()
    if not store.has_pack(name):
        packs = find_packs() if packs is None else packs
        needed = {archive for pack in packs if pack.name == name for archive in pack.archives}
        packs = [pack for pack in packs if needed.issuperset(pack.archives)]
        fetch_packs(store, packs=packs, report=source.report)
    return store.open_pack(name)


def fetch_packs(
    store: DataPackStore | None = None,
    *,
    packs: Sequence[DataPack],
    archives_path: Path | None = None,
    force: bool = False,
    report: ReportProgress = ignore_progress,
) -> tuple[str, ...]:
    """Make packs (data packages) in the store. A second process waits, and uses the packs of the first.

    Args:
        store: the folder of packs; the user's default store if None.
        packs: the packs to make.
        archives_path: an archive, a folder of archives or an unpacked wheel, to be read in place of a
            download. Packs that need another archive are left out.
        force: make packs again if they exist.
        report: called with each step of progress.

    Returns:
        Names of the packs that were made.

    Raises:
        DataError: an archive cannot be obtained or differs from the published archive, or the store is not
            writable.
    """
    store = store or DataPackStore()
    if not (force or _find_missing_packs(store, packs)):
        return ()
    with _lock_folder(store.folder, report):
        wanted = list(packs) if force else _find_missing_packs(store, packs)
        if not wanted:
            return ()
        store.remove_partial_packs()
        with ExitStack() as stack:
            paths = _open_archives(wanted, archives_path, report, stack)
            wanted = [pack for pack in wanted if paths.keys() >= set(pack.archives)]
            if archives_path is not None and not wanted:
                files = ", ".join(sorted({archive.filename for pack in packs for archive in pack.archives}))
                raise DataError(f"{archives_path}: contains none of {files}; give a path with one of them")
            bundles = {
                archive: stack.enter_context(open_archive_files(path)) for archive, path in paths.items()
            }
            for pack in wanted:
                opened = [bundles[archive] for archive in pack.archives]
                store.write_pack(pack.name, pack.archive_digests, pack.convert(*opened, report))
    return tuple(pack.name for pack in wanted)


def get_pack_statuses(store: DataPackStore, *, packs: Sequence[DataPack]) -> tuple[_DataPackStatus, ...]:
    """Return the status of each pack (data package). Absent or damaged packs raise no error."""
    return tuple(_get_status(store, pack) for pack in packs)


def is_stored(store: DataPackStore, benchmark: str) -> bool:
    """Whether a store has a benchmark's packs (data packages), so that its tasks open without a download.

    A benchmark without registered packs uses those of the benchmark with which its name begins:
    ``behavior-1k-untold`` uses the packs of ``behavior-1k``. The longest such name counts.
    """
    prefixes = [name for name in _get_entry_points() if benchmark.startswith(name)]
    packs = find_packs(sorted(prefixes, key=len)[-1:])
    return not any(status.problem for status in get_pack_statuses(store, packs=packs))


def validate_packs(store: DataPackStore, packs: Sequence[DataPack] | None = None) -> tuple[DataMistake, ...]:
    """Return the problems of the packs (data packages) in a store. No archive is downloaded.

    Args:
        store: the folder of packs.
        packs: the packs to check; if None, packs of the paper's benchmarks, and other packs in the store.

    Returns:
        The problems; empty if the store is valid.
    """
    if packs is None:
        needed = {pack.name for pack in find_packs(list_paper_benchmarks())}
        packs = [pack for pack in find_packs() if pack.name in needed or store.has_pack(pack.name)]
    broken = tuple(finding for pack in packs for finding in _check_pack_files(store, pack))
    return broken or tuple(DataMistake(pack.name, problem) for pack in packs for problem in pack.check(store))


def _check_pack_files(store: DataPackStore, pack: DataPack) -> Iterator[DataMistake]:
    try:
        opened = store.open_pack(pack.name)
    except DataError as error:
        yield DataMistake(pack.name, str(error))
        return
    if opened.archives != pack.archive_digests:
        yield DataMistake(
            pack.name, "was made from archives other than the pinned ones; run `eai data fetch`"
        )
    for member in opened.members:
        try:
            opened.read_member(member)
        except DataError as error:
            yield DataMistake(pack.name, str(error))


def _get_status(store: DataPackStore, pack: DataPack) -> _DataPackStatus:
    path = store.get_pack_path(pack.name)
    size = path.stat().st_size if path.is_file() else 0
    try:
        opened = store.open_pack(pack.name)
    except DataError as error:
        return _DataPackStatus(pack.name, size, None, pack.archive_digests, str(error))
    return _DataPackStatus(pack.name, size, opened.sha256, opened.archives, None)


def _find_missing_packs(store: DataPackStore, packs: Sequence[DataPack]) -> list[DataPack]:
    """Return the packs (data packages) that are absent, unreadable or not made from the expected archives."""
    statuses = [(pack, _get_status(store, pack)) for pack in packs]
    return [
        pack
        for pack, status in statuses
        if status.problem is not None or status.archives != pack.archive_digests
    ]


@contextmanager
def _lock_folder(folder: Path, report: ReportProgress) -> Iterator[None]:
    """Hold the lock of a folder, after waiting for other processes that hold it."""
    from filelock import Timeout

    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, lock = make_file_lock(folder / "fetch.lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            report("waiting for", f"another process that fetches the data{make_stale_lock_hint(file)}", 0, 0)
            lock.acquire()
    except OSError as error:
        raise make_unwritable_error(folder, error) from error
    try:
        yield
    finally:
        lock.release()


def _open_archives(
    packs: Sequence[DataPack], archives_path: Path | None, report: ReportProgress, stack: ExitStack
) -> dict[PackageArchive, Path]:
    """Return the paths of the verified archives. They are in `archives_path`, or in a temporary folder."""
    archives = dict.fromkeys(archive for pack in packs for archive in pack.archives)
    if archives_path is not None:
        paths_by_archive = {
            archive: source.find_verified_archive(archive, archives_path) for archive in archives
        }
        return {archive: path for archive, path in paths_by_archive.items() if path is not None}
    pip = source.find_command_that_runs_pip(next(iter(archives)))
    paths = {}
    for archive in archives:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="eai-")))
        paths[archive] = source.download_archive(archive, folder, report, pip)
    return paths
