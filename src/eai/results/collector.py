"""A process with the garbage collector at rest: of garbage there is little among all that is kept."""

from __future__ import annotations

import gc

SELDOM = 300_000
"""After how many new objects the collector looks through them; by itself it does so after some hundreds."""


def collect_seldom() -> None:
    """Spare the garbage collector what is there already, and have it seldom look at what comes.

    For a process that does nothing else as long as it lives: modules, tasks and records are kept anyway.
    """
    gc.freeze()
    gc.set_threshold(SELDOM, *gc.get_threshold()[1:])
