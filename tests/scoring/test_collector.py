from __future__ import annotations

import gc

import pytest

from eai.scoring.collector import collecting_seldom


def test_the_garbage_collector_is_left_as_it_was() -> None:
    frozen, threshold = gc.get_freeze_count(), gc.get_threshold()
    with collecting_seldom():
        assert gc.get_freeze_count() > frozen
        assert gc.get_threshold() > threshold
    assert gc.get_freeze_count() == 0
    with pytest.raises(RuntimeError), collecting_seldom():
        raise RuntimeError
    assert gc.get_freeze_count() == 0
    assert gc.get_threshold() == threshold
