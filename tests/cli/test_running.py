"""What ``eai run`` does once the model has answered; whole runs are in `test_run`."""

from __future__ import annotations

import gc

import pytest

from eai.cli.running import undisturbed


def test_the_garbage_collector_is_left_as_it_was() -> None:
    before = gc.get_freeze_count()
    with undisturbed():
        assert gc.get_freeze_count() > before
    assert gc.get_freeze_count() == 0
    with pytest.raises(RuntimeError), undisturbed():
        raise RuntimeError
    assert gc.get_freeze_count() == 0
