"""Ask one question from many threads that switch as often as possible."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

THREADS = 8


def asked_by_threads(is_right: Callable[[int], bool], times: int) -> bool:
    """Return whether a question has the right answer each time; it is asked with the numbers from 0 on."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            return all(pool.map(is_right, range(times), chunksize=50))
    finally:
        sys.setswitchinterval(interval)
