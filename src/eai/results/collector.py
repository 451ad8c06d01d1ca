"""Makes the garbage collector run rarely, for processes that keep nearly all objects."""

from __future__ import annotations

import gc

OBJECTS_BETWEEN_COLLECTIONS = 300_000
"""Number of new objects after which the collector runs; Python's default is some hundreds."""


def reduce_garbage_collection() -> None:
    """Exclude all existing objects from garbage collection, and collect later objects rarely.

    This suits a process that keeps its modules, tasks and records until it ends.
    """
    gc.freeze()
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, *gc.get_threshold()[1:])
