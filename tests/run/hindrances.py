"""Functions that interrupt a command or block it, called by name in the command's process."""

from __future__ import annotations

import itertools
import signal
from typing import Any, NoReturn


def interrupt_at(number: int) -> None:
    """Make the process interrupt itself after a number of answers."""
    from eai.run.journal import RunState

    take, taken = RunState.add_answer, itertools.count(1)

    def interrupting(*arguments: Any) -> None:
        take(*arguments)
        if next(taken) == number:
            signal.raise_signal(signal.SIGINT)

    RunState.add_answer = interrupting  # type: ignore[method-assign]


def search_forever() -> None:
    """Install a planner that never ends."""
    from eai.planning.planner import Planner

    def search(*_: object) -> NoReturn:
        print("searching", flush=True)
        while True:
            pass

    Planner.find_plan = search  # type: ignore[assignment]
