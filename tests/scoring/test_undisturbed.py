from __future__ import annotations

import gc

import pytest

from eai.scoring.undisturbed import undisturbed


def test_the_garbage_collector_is_left_as_it_was() -> None:
    frozen, threshold = gc.get_freeze_count(), gc.get_threshold()
    with undisturbed():
        assert gc.get_freeze_count() > frozen
        assert gc.get_threshold() > threshold
    assert gc.get_freeze_count() == 0
    with pytest.raises(RuntimeError), undisturbed():
        raise RuntimeError
    assert gc.get_freeze_count() == 0
    assert gc.get_threshold() == threshold
