"""Ask one question from many threads that switch as often as possible."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

THREADS = 8


def asked_by_threads(is_right: Callable[[int], bool], times: int) -> bool:
    """Return whether `is_right` is true for each number from 0 on, called from many threads."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            return all(pool.map(is_right, range(times), chunksize=50))
    finally:
        sys.setswitchinterval(interval)
