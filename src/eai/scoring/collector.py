"""Scoring with the garbage collector at rest: of garbage there is none among all that is kept."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

SELDOM = 100_000
"""After how many new objects the collector looks through them; by itself it does so after some hundreds."""


@contextmanager
def collecting_seldom() -> Iterator[None]:
    """Spares the garbage collector what is there already, and has it seldom look at what comes.

    Among all of Inspect it would search for long, and tasks and records are kept anyway.
    """
    before = gc.get_threshold()
    collect_seldom()
    try:
        yield
    finally:
        gc.set_threshold(*before)
        gc.unfreeze()


def collect_seldom() -> None:
    """The same for a process that does nothing else as long as it lives."""
    gc.freeze()
    gc.set_threshold(SELDOM, *gc.get_threshold()[1:])
