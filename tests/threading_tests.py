"""Asking one thing from many threads that take turns as often as they can."""

from __future__ import annotations

import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

THREADS = 8


def asked_by_threads(is_right: Callable[[int], bool], times: int) -> bool:
    """Whether a question has the right answer each time, numbers from 0 on being given to it."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(THREADS) as pool:
            return all(pool.map(is_right, range(times), chunksize=50))
    finally:
        sys.setswitchinterval(interval)
