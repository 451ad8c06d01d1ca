"""How much of a suite a run answers, and whether its numbers can be ranked with those of others.

Also what errata of the data did to the numbers of a run, as its records say it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import reduce

from eai.base.json_value import Json


@dataclass(frozen=True, slots=True)
class Coverage:
    """How many tasks of a suite are asked, answered, and counted.

    Attributes:
        asked: tasks with a record.
        answered: those of them with an answer.
        failed: those without one that count as failures.
        left_out: those without one that are left out of all rates for it (``--allow-missing``).
        tasks: all tasks of the suite; None if the records do not say.
        raised: number of tasks with an answer whose scorer raised an exception, which counts as failed.
    """

    asked: int
    answered: int
    failed: int = 0
    left_out: int = 0
    tasks: int | None = None
    raised: int = 0

    @property
    def ranked(self) -> bool:
        """Whether every task of the suite is asked, and an unanswered one is no advantage."""
        return self.asked == self.tasks and not self.left_out

    @property
    def remark(self) -> str | None:
        """A remark for readers of the numbers, as one sentence; None if every task is answered and scored."""
        if self.tasks is None:
            return (
                "The records do not say how many tasks the suite has: score the answers again to rank them."
            )
        parts = tuple(self._gaps(self.tasks))
        end = "." if self.ranked else "; the run is not ranked."
        return "; ".join(parts) + end if parts else None

    def _gaps(self, tasks: int) -> Iterable[str]:
        if self.raised:
            yield f"{self.raised} failed because the scorer raised an exception, which the record names"
        if self.asked < tasks:
            yield f"only {self.asked} of {tasks} tasks were asked"
        lacking = self.asked - self.answered
        if not lacking:
            return
        if self.left_out:
            fate = f"left out, but {self.failed} counted as failed" if self.failed else "left out"
        elif self.failed == lacking:
            fate = "counted as failed"
        else:
            fate = f"counted as failed where they are in the statistics ({self.failed})"
        yield f"{lacking} of {self.asked} tasks without an answer, {fate}"

    def __add__(self, other: Coverage) -> Coverage:
        """That of two suites together."""
        known = None if self.tasks is None or other.tasks is None else self.tasks + other.tasks
        return Coverage(
            self.asked + other.asked,
            self.answered + other.answered,
            self.failed + other.failed,
            self.left_out + other.left_out,
            known,
            self.raised + other.raised,
        )

    def __str__(self) -> str:
        return f"{self.answered}/{'?' if self.tasks is None else self.tasks}"

    def to_json(self) -> dict[str, Json]:
        """The coverage as ``summary.json`` has it."""
        return {
            "tasks": self.tasks,
            "answered": self.answered,
            "unanswered": self.asked - self.answered,
            "counted_as_failures": self.failed,
            "left_out": self.left_out,
            "not_asked": None if self.tasks is None else self.tasks - self.asked,
            "ranked": self.ranked,
            **({"raised": self.raised} if self.raised else {}),
        }


def combine_coverage(coverages: Iterable[Coverage]) -> Coverage | None:
    """That of several suites; None of none."""
    found = tuple(coverages)
    return reduce(Coverage.__add__, found) if found else None


@dataclass(frozen=True, slots=True)
class ErrataEffect:
    """How many tasks of a run errata left out or corrected.

    Attributes:
        version: of the errata.
        tasks: tasks with a record.
        scored: those of them that rates are of.
        left_out: ids of those that errata left out of all rates.
        corrected: ids of those that were scored with a correction.
    """

    version: str
    tasks: int
    scored: int
    left_out: tuple[str, ...]
    corrected: tuple[str, ...]

    @property
    def remark(self) -> str | None:
        """One sentence for the reader of the numbers, and how to undo it; None if nothing was done."""
        done = [
            f"{len(task_ids)} {how}"
            for task_ids, how in ((self.left_out, "left out"), (self.corrected, "corrected"))
            if task_ids
        ]
        if not done:
            return None
        return (
            f"Of {self.tasks} tasks, {' and '.join(done)}, because the published data is wrong there "
            "(docs/errata.md); --errata none takes it as published."
        )

    def to_json(self) -> dict[str, Json]:
        """The effect as ``summary.json`` has it."""
        return {**asdict(self), "left_out": [*self.left_out], "corrected": [*self.corrected]}
