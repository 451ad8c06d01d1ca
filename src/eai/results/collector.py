"""Collects garbage rarely in a process that keeps nearly all objects, and often in runs of models."""

from __future__ import annotations

import gc

OBJECTS_BETWEEN_COLLECTIONS = 300_000
"""Number of new objects after which the garbage collector runs; Python's default is some hundreds."""


def reduce_garbage_collection() -> None:
    """Exclude all existing objects from garbage collection, and collect later objects rarely.

    This suits a process that keeps its modules, tasks and records until it ends.
    """
    gc.freeze()
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, *gc.get_threshold()[1:])


def set_low_garbage_collection_threshold() -> None:
    """Collect garbage after 2,000 new objects.

    The library Inspect, which runs models, leaves some 100 kB of cyclic garbage a sample.
    """
    gc.set_threshold(2000, *gc.get_threshold()[1:])
