"""Makes the garbage collector run rarely, for processes that keep nearly all objects."""

from __future__ import annotations

import gc

OBJECTS_BETWEEN_COLLECTIONS = 300_000
"""Number of new objects after which the collector runs; Python's default is some hundreds."""


def collect_seldom() -> None:
    """Exclude all present objects from garbage collection, and collect new objects rarely.

    This suits processes with one purpose, which keep their modules, tasks and records until they end.
    """
    gc.freeze()
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, *gc.get_threshold()[1:])
