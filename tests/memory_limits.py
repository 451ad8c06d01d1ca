"""Limits on the memory of the test run. Linux only: elsewhere nothing is limited or measured."""

from __future__ import annotations

import gc
import sys
from collections.abc import Generator
from functools import _lru_cache_wrapper
from pathlib import Path

import pytest

if sys.platform == "linux":
    import resource

_MAX_TEST_BYTES = 500 << 20
"""Limit on how much a test may add to the resident memory of its process."""

_MAX_PROCESS_BYTES = 2 << 30
"""Limit on the resident memory of each process."""

_MAX_WRITABLE_BYTES = 5 << 30
"""Limit on the writable memory of each process.

Some of it stays untouched: pyarrow reserves 1 GiB, and each log that Inspect compresses reserves 220 MiB.
"""

_MAX_GROWTH_BYTES = 64 << 20
"""Growth of a large process after which its memory is freed."""

_resident_after_freeing = [0]
"""Resident size of this process after its memory was last freed, in bytes."""

_BEFORE = pytest.StashKey[tuple[int, int]]()


def limit_writable_memory() -> None:
    """Make allocations fail beyond `_MAX_WRITABLE_BYTES`, here and in all processes that are started here.

    A test that asks for too much then fails before the machine runs out of memory. Chromium, MuJoCo and Ray
    reserve far more addresses than they write to, so a limit on addresses (RLIMIT_AS) would stop them.
    """
    if sys.platform == "linux":
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = _MAX_WRITABLE_BYTES if hard == resource.RLIM_INFINITY else min(hard, _MAX_WRITABLE_BYTES)
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, object, object]:
    """Record the memory of this process and its children before the fixtures of a test are made."""
    if sys.platform == "linux":
        Path("/proc/self/clear_refs").write_text("5")  # resets the peak to the present size
        item.stash[_BEFORE] = _peak_bytes(), _peak_bytes_of_children()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    """Fail a test that takes more than `_MAX_TEST_BYTES`, or brings a process above `_MAX_PROCESS_BYTES`."""
    outcome = yield
    if sys.platform == "linux":
        before, of_children_before = item.stash[_BEFORE]
        peak, of_children = _peak_bytes(), _peak_bytes_of_children()
        _check("the test", peak - before, _MAX_TEST_BYTES)
        _check("its process", peak, _MAX_PROCESS_BYTES)
        if of_children > of_children_before:
            _check("a process that it starts", of_children, _MAX_PROCESS_BYTES)
    return outcome


def is_memory_to_be_freed() -> bool:
    """Whether this process has more than half of its limit, and grew by 64 MiB since its memory was freed."""
    least = max(_MAX_PROCESS_BYTES // 2, _resident_after_freeing[0] + _MAX_GROWTH_BYTES)
    return sys.platform == "linux" and _resident_bytes() > least


def free_memory() -> None:
    """Collect all garbage, also among frozen objects, and empty all caches of bounded size."""
    gc.unfreeze()
    for each in gc.get_objects():
        if isinstance(each, _lru_cache_wrapper) and each.cache_parameters()["maxsize"] is not None:
            each.cache_clear()
    gc.collect()
    _resident_after_freeing[0] = _resident_bytes()


def _check(taker: str, taken: int, limit: int) -> None:
    if taken > limit:
        pytest.fail(f"{taker} takes {taken >> 20} MiB of memory, more than {limit >> 20} MiB", pytrace=False)


def _peak_bytes() -> int:
    """Return the largest resident size of this process since the peak was reset."""
    return _read_status_bytes("VmHWM:")


def _resident_bytes() -> int:
    return _read_status_bytes("VmRSS:")


def _read_status_bytes(name: str) -> int:
    status = Path("/proc/self/status").read_text()
    return int(status.partition(name)[2].split(maxsplit=1)[0]) << 10


def _peak_bytes_of_children() -> int:
    """Return the largest resident size of all child processes that have ended."""
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss << 10
