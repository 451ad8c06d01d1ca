"""Planning together: room for planners, shared by processes through a folder."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout

_PAUSE = 0.05
"""Seconds until a seat is looked for again; a call of a planner takes longer."""


@dataclass(frozen=True, slots=True)
class Seats:
    """So many planners at a time, in all processes that share a folder; who ends gives its seat back.

    Attributes:
        number: how many.
        folder: the folder.
    """

    number: int
    folder: Path

    @contextmanager
    def taken(self) -> Iterator[None]:
        """Wait for a seat, and keep it during the block."""
        locks = [FileLock(self.folder / f"seat-{i}.lock", timeout=0) for i in range(self.number)]
        while True:
            for lock in locks:
                try:
                    lock.acquire()
                except Timeout:
                    continue
                try:
                    yield
                finally:
                    lock.release()
                return
            time.sleep(_PAUSE)


def machine_memory_mib() -> int:
    """The memory that there is: of the machine, or of the control group that this process is confined to."""
    most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limit = Path("/sys/fs/cgroup/memory.max")
    text = limit.read_text().strip() if limit.is_file() else ""
    return (min(most, int(text)) if text.isdigit() else most) >> 20
