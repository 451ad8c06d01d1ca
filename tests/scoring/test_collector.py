from __future__ import annotations

import gc

from eai.scoring.collector import SELDOM, collect_seldom


def test_the_garbage_collector_is_spared_what_is_there() -> None:
    threshold = gc.get_threshold()
    try:
        collect_seldom()
        assert gc.get_freeze_count() > 0
        assert gc.get_threshold() == (SELDOM, *threshold[1:])
    finally:
        gc.set_threshold(*threshold)
        gc.unfreeze()
