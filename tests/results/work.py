"""Work for worker processes, in a module that they can import."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from eai.abilities.explanation import VerdictExplanation
from eai.abilities.protocol import Ability, Protocol
from eai.abilities.scorer import Assessment, Scorer
from eai.abilities.verdict import PlanVerdict
from eai.benchmarks.registry import find_benchmark
from eai.benchmarks.suite import Suite
from eai.tasks.source import TaskSet

TASK_IDS = tuple(f"{number}_1" for number in range(7))


@dataclass(frozen=True, slots=True)
class Echo(Scorer):
    """A scorer whose verdict repeats the answer."""

    task_id: str

    def assess(self, text: str) -> Assessment:
        verdict = PlanVerdict(success=text.endswith(self.task_id))
        return Assessment(verdict, lambda: VerdictExplanation(notes=(f"on {text}",)))


def echo_suite() -> Suite:
    benchmark, scorers = find_benchmark("virtualhome"), TaskSet(TASK_IDS, Echo, "0" * 64)
    return Suite(benchmark, Ability.ACTION_SEQUENCING, Protocol.STRICT, scorers, echo_suite)


def squares(items: Sequence[int]) -> list[int]:
    return [item * item for item in items]


def large(items: Sequence[int]) -> list[bytes]:
    """Return results of four megabytes, which do not fit into a pipe."""
    return [bytes(4 << 20) for _ in items]


def cubes(items: Sequence[int]) -> list[int]:
    return [item**3 for item in items]


def failing(items: Sequence[int]) -> list[int]:
    raise ValueError("no")


def asleep(items: Sequence[int]) -> list[int]:
    time.sleep(3600)
    return []


@dataclass(frozen=True)
class Dying:
    """Work that kills its process at a number, unless a file exists."""

    at: int
    once: Path

    def __call__(self, items: Sequence[int]) -> list[int]:
        if self.at in items and not self.once.exists():
            self.once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return squares(items)


def deadly(items: Sequence[int]) -> list[int]:
    os.kill(os.getpid(), signal.SIGKILL)
    return []


def folder_of_files(items: Sequence[int]) -> list[str]:
    """Leave a file and a folder in the folder for temporary files."""
    return [str(Path(tempfile.mkdtemp(prefix="left-"), "file")) for _ in items]


def unspeakable(items: Sequence[int]) -> list[int]:
    class UnspeakableError(Exception):
        """An exception that cannot be pickled."""

    raise UnspeakableError("of no module")
