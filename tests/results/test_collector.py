from __future__ import annotations

import gc

from eai.results.collector import OBJECTS_BETWEEN_COLLECTIONS, reduce_garbage_collection


def test_present_objects_are_excluded_from_garbage_collection() -> None:
    threshold, is_spared = gc.get_threshold(), gc.get_freeze_count() > 0
    gc.unfreeze()
    gc.set_threshold(700, 10, 10)
    try:
        reduce_garbage_collection()
        assert gc.get_freeze_count() > 0
        assert gc.get_threshold() == (OBJECTS_BETWEEN_COLLECTIONS, 10, 10)
    finally:
        gc.set_threshold(*threshold)
        if not is_spared:
            gc.unfreeze()
