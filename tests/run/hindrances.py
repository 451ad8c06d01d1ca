"""What makes a command stop or never end, called by its name in the process of the command."""

from __future__ import annotations

import itertools
import signal
from typing import NoReturn


def interrupt_at(number: int) -> None:
    """Have the process interrupt itself when it has taken so many answers."""
    from eai.run.journal import Answer, RunState

    take, taken = RunState.add_answer, itertools.count(1)

    def interrupting(desk: RunState, answer: Answer) -> None:
        take(desk, answer)
        if next(taken) == number:
            signal.raise_signal(signal.SIGINT)

    RunState.add_answer = interrupting  # type: ignore[method-assign]


def search_forever() -> None:
    """Have a planner that never comes to an end."""
    from eai.planning.planner import Planner

    def search(*_: object) -> NoReturn:
        print("searching", flush=True)
        while True:
            pass

    Planner.plan = search  # type: ignore[assignment]
