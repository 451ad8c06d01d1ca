"""Fetch, convert, check and open the packs of the data store. Opening an absent pack fetches it first.

A distribution registers the packs of a benchmark by an entry point of the group ``eai.packs``: a sequence of
`Pack`, under the benchmark's name. It may hold packs that another benchmark registers as well.
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
from eai.base.files import make_lock, stale_lock_hint
from eai.base.source import Archive, open_bundle
from eai.base.store import PackFile, ReportProgress, Store, ignore_progress, unwritable_error
from eai.benchmarks.registry import FIRST, of_the_paper
from eai.tasks.source import Finding, Source

GROUP = "eai.packs"
"""The group of entry points."""


def _no_problems(store: Store) -> Iterable[str]:
    return ()


@dataclass(frozen=True, slots=True)
class Pack:
    """One file of the store.

    Attributes:
        name: the pack's name in `Store.open`.
        archives: the archives that it is made from.
        convert: makes content by member from the files of each archive, and reports progress. The same files
            give the same bytes. Raises DataError.
        check: yields the problems of its content, once all packs can be read.
    """

    name: str
    archives: tuple[Archive, ...]
    convert: Callable[..., Mapping[str, bytes]]
    check: Callable[[Store], Iterable[str]] = _no_problems

    @property
    def pins(self) -> dict[str, str]:
        """Requirement -> SHA-256 of its archives, as the pack's manifest records them."""
        return {archive.requirement: archive.sha256 for archive in self.archives}


@dataclass(frozen=True, slots=True)
class _PackStatus:
    """The status of one pack, as `eai data info` prints it.

    Attributes:
        size: bytes on disk; 0 when absent.
        sha256: digest of the content; None when absent or damaged.
        problem: one line that says what to do; None when the pack is ready.
    """

    pack: str
    size: int
    sha256: str | None
    archives: Mapping[str, str]
    problem: str | None


def registered_packs(benchmarks: Iterable[str] | None = None) -> tuple[Pack, ...]:
    """Return the packs that are registered for some benchmarks, or for all if None, each once."""
    points = _entry_points()
    names = [name for name in (points if benchmarks is None else benchmarks) if name in points]
    return tuple({pack.name: pack for name in names for pack in points[name].load()}.values())


def _entry_points() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, FIRST)


def open_pack(name: str, source: Source | None = None, *, packs: Sequence[Pack] | None = None) -> PackFile:
    """Open a pack by name; when it is absent, fetch it with all that its archives suffice for.

    Args:
        name: the pack's name.
        source: the store; the user's default one if None.
        packs: the packs that may be fetched; all that are registered if None.

    Raises:
        DataError: it cannot be obtained, or is damaged.
    """
    source = source or Source()
    store = source.store or Store()
    if not store.has(name):
        packs = registered_packs() if packs is None else packs
        needed = {archive for pack in packs if pack.name == name for archive in pack.archives}
        packs = [pack for pack in packs if needed.issuperset(pack.archives)]
        fetch(store, packs=packs, report=source.report)
    return store.open(name)


def fetch(
    store: Store | None = None,
    *,
    packs: Sequence[Pack],
    place: Path | None = None,
    force: bool = False,
    report: ReportProgress = ignore_progress,
) -> tuple[str, ...]:
    """Bring packs into the store; two processes may do so at once, the second then finds the work done.

    Args:
        store: the folder of packs; the user's default one if None.
        packs: what to bring.
        place: an archive, a folder of archives or an unpacked wheel, instead of the package index; packs that
            need an archive which is not there are left out.
        force: make packs anew although they are there.
        report: called with each step forward.

    Returns:
        Names of the packs that were made.

    Raises:
        DataError: an archive cannot be obtained or is not as published, or the store cannot be written.
    """
    store = store or Store()
    if not (force or _missing(store, packs)):
        return ()
    with _locked(store.folder, report):
        wanted = list(packs) if force else _missing(store, packs)
        if not wanted:
            return ()
        store.remove_partial_files()
        with ExitStack() as stack:
            paths = _obtain(wanted, place, report, stack)
            wanted = [pack for pack in wanted if paths.keys() >= set(pack.archives)]
            if place is not None and not wanted:
                files = ", ".join(sorted({each.filename for pack in packs for each in pack.archives}))
                raise DataError(f"{place}: holds none of {files}")
            bundles = {archive: stack.enter_context(open_bundle(path)) for archive, path in paths.items()}
            for pack in wanted:
                opened = [bundles[archive] for archive in pack.archives]
                store.write(pack.name, pack.pins, pack.convert(*opened, report))
    return tuple(pack.name for pack in wanted)


def info(store: Store, *, packs: Sequence[Pack]) -> tuple[_PackStatus, ...]:
    """Return the status of each pack; a damaged or absent one is reported, not raised."""
    return tuple(_status(store, pack) for pack in packs)


def is_at_hand(store: Store, benchmark: str) -> bool:
    """Whether a store has the packs of a benchmark, so that opening its tasks fetches nothing.

    A benchmark without packs of its own name has those of the name with which its own begins, if any.
    """
    beginnings = [name for name in _entry_points() if benchmark.startswith(name)]
    packs = registered_packs(sorted(beginnings, key=len)[-1:])
    return not any(status.problem for status in info(store, packs=packs))


def validate(store: Store, packs: Sequence[Pack] | None = None) -> tuple[Finding, ...]:
    """Check every pack of a store; nothing is fetched.

    Args:
        store: the folder of packs.
        packs: the packs to check; those of the paper's benchmarks, and the others that are fetched, if None.

    Returns:
        The problems; empty when the store is valid.
    """
    if packs is None:
        needed = {pack.name for pack in registered_packs(of_the_paper())}
        packs = [pack for pack in registered_packs() if pack.name in needed or store.has(pack.name)]
    broken = tuple(finding for pack in packs for finding in _check_files(store, pack))
    return broken or tuple(Finding(pack.name, problem) for pack in packs for problem in pack.check(store))


def _check_files(store: Store, pack: Pack) -> Iterator[Finding]:
    try:
        opened = store.open(pack.name)
    except DataError as error:
        yield Finding(pack.name, str(error))
        return
    if opened.archives != pack.pins:
        yield Finding(pack.name, "was made from other archives than the pinned ones; run `eai data fetch`")
    for member in opened.members:
        try:
            opened.read(member)
        except DataError as error:
            yield Finding(pack.name, str(error))


def _status(store: Store, pack: Pack) -> _PackStatus:
    path = store.path(pack.name)
    size = path.stat().st_size if path.is_file() else 0
    try:
        found = store.open(pack.name)
    except DataError as error:
        return _PackStatus(pack.name, size, None, pack.pins, str(error))
    return _PackStatus(pack.name, size, found.sha256, found.archives, None)


def _missing(store: Store, packs: Sequence[Pack]) -> list[Pack]:
    """Packs that are absent, unreadable or made from other archives."""
    found = [(pack, _status(store, pack)) for pack in packs]
    return [pack for pack, status in found if status.problem is not None or status.archives != pack.pins]


@contextmanager
def _locked(folder: Path, report: ReportProgress) -> Iterator[None]:
    """Hold the folder's lock, waiting for another process if need be."""
    from filelock import Timeout

    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, lock = make_lock(folder / "fetch.lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            report("waiting for", f"another process that fetches the data{stale_lock_hint(file)}", 0, 0)
            lock.acquire()
    except OSError as error:
        raise unwritable_error(folder, error) from error
    try:
        yield
    finally:
        lock.release()


def _obtain(
    packs: Sequence[Pack], place: Path | None, report: ReportProgress, stack: ExitStack
) -> dict[Archive, Path]:
    """The verified archives of the packs, found at `place` or downloaded to a folder that `stack` removes."""
    archives = dict.fromkeys(archive for pack in packs for archive in pack.archives)
    if place is not None:
        found = {archive: source.find_archive(archive, place) for archive in archives}
        return {archive: path for archive, path in found.items() if path is not None}
    pip = source.find_pip(next(iter(archives)))
    paths = {}
    for archive in archives:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="eai-")))
        paths[archive] = source.download(archive, folder, report, pip)
    return paths
