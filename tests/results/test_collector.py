from __future__ import annotations

import gc

from eai.results.collector import OBJECTS_BETWEEN_COLLECTIONS, collect_seldom


def test_present_objects_are_excluded_from_garbage_collection() -> None:
    threshold, is_spared = gc.get_threshold(), gc.get_freeze_count() > 0
    gc.unfreeze()
    gc.set_threshold(700, 10, 10)
    try:
        collect_seldom()
        assert gc.get_freeze_count() > 0
        assert gc.get_threshold() == (OBJECTS_BETWEEN_COLLECTIONS, 10, 10)
    finally:
        gc.set_threshold(*threshold)
        if not is_spared:
            gc.unfreeze()
