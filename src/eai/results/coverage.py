"""Coverage: how many tasks of a suite a run answers, and whether the run can be ranked.

This module also lists the tasks of a run that errata (known errors of the data set) left out or corrected.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import reduce

from eai.base.json_value import Json


@dataclass(frozen=True, slots=True)
class TaskCoverageByAnswers:
    """Numbers of tasks of a suite (ability in a benchmark) in a run: asked, answered, and counted in rates.

    Attributes:
        asked: number of tasks with a record.
        answered: number of tasks with an answer.
        failed: number of tasks without an answer that count as failures.
        left_out: number of tasks without an answer that are left out of all rates (``--allow-missing``).
        tasks: number of all tasks of the suite; None if the records do not state it.
        raised: number of tasks whose scorer raised an exception for the answer, which counts as failed.
        cut_off: number of tasks with an answer that a length limit cut off.
    """

    asked: int
    answered: int
    failed: int = 0
    left_out: int = 0
    tasks: int | None = None
    raised: int = 0
    cut_off: int = 0

    @property
    def is_complete_enough_for_ranking(self) -> bool:
        """Whether the run may be ranked: every task has a record, and missing answers count as failures."""
        return self.asked == self.tasks and not self.left_out

    @property
    def remark_on_missing_answers(self) -> str | None:
        """One sentence on missing tasks and answers; None if every task is answered and scored."""
        if self.tasks is None:
            return (
                "The records do not say how many tasks the suite has: score the answers again to rank them."
            )
        parts = tuple(self._describe_answer_problems(self.tasks))
        end = "." if self.is_complete_enough_for_ranking else "; the run is not ranked."
        return "; ".join(parts) + end if parts else None

    def _describe_answer_problems(self, task_count: int) -> Iterable[str]:
        if self.raised:
            yield f"{self.raised} failed because the scorer raised an exception, which the record names"
        if self.cut_off:
            yield f"{self.cut_off} of {self.answered} answers were cut off at a length limit"
        if self.asked < task_count:
            yield f"only {self.asked} of {task_count} tasks were asked"
        missing = self.asked - self.answered
        if not missing:
            return
        if not self.answered:
            yield f"no answer to any of {self.asked} tasks"
            return
        if self.left_out:
            treatment = f"left out, but {self.failed} counted as failed" if self.failed else "left out"
        elif self.failed == missing:
            treatment = "counted as failed"
        else:
            treatment = f"counted as failed where they are in the statistics ({self.failed})"
        yield f"{missing} of {self.asked} tasks without an answer, {treatment}"

    def __add__(self, other: TaskCoverageByAnswers) -> TaskCoverageByAnswers:
        """Return the sum of this coverage and another."""
        tasks = None if self.tasks is None or other.tasks is None else self.tasks + other.tasks
        return TaskCoverageByAnswers(
            self.asked + other.asked,
            self.answered + other.answered,
            self.failed + other.failed,
            self.left_out + other.left_out,
            tasks,
            self.raised + other.raised,
            self.cut_off + other.cut_off,
        )

    def __str__(self) -> str:
        return f"{self.answered}/{'?' if self.tasks is None else self.tasks}"

    def to_json(self) -> dict[str, Json]:
        """Return the numbers of answered and unanswered tasks, in the form of ``summary.json``."""
        return {
            "tasks": self.tasks,
            "answered": self.answered,
            "unanswered": self.asked - self.answered,
            "counted_as_failures": self.failed,
            "left_out": self.left_out,
            "not_asked": None if self.tasks is None else self.tasks - self.asked,
            "ranked": self.is_complete_enough_for_ranking,
            **({"raised": self.raised} if self.raised else {}),
            **({"cut_off": self.cut_off} if self.cut_off else {}),
        }


def combine_coverage(coverages: Iterable[TaskCoverageByAnswers]) -> TaskCoverageByAnswers | None:
    """Return the numbers of answered and unanswered tasks in several suites together; None without suites."""
    coverages_of_suites = tuple(coverages)
    return reduce(TaskCoverageByAnswers.__add__, coverages_of_suites) if coverages_of_suites else None


@dataclass(frozen=True, slots=True)
class TasksChangedByErrata:
    """The tasks of a run that errata, known errors of the data set, left out or corrected.

    Attributes:
        version: version of the errata.
        tasks: number of tasks with a record.
        scored: number of tasks that count in rates.
        left_out: ids of the tasks that errata left out of all rates.
        corrected: ids of the tasks that were scored with a correction.
    """

    version: str
    tasks: int
    scored: int
    left_out: tuple[str, ...]
    corrected: tuple[str, ...]

    @property
    def remark_on_errata(self) -> str | None:
        """Sentence with the numbers of tasks that errata leave out or correct; None if no task changes.

        It ends with the option that scores without errata.
        """
        effects = [
            f"{len(task_ids)} {how}"
            for task_ids, how in ((self.left_out, "left out"), (self.corrected, "corrected"))
            if task_ids
        ]
        if not effects:
            return None
        return (
            f"Of {self.tasks} tasks, {' and '.join(effects)}, because the published data is wrong there "
            "(docs/errata.md); --errata none takes it as published."
        )

    def to_json(self) -> dict[str, Json]:
        """Return the attributes as ``summary.json`` stores them."""
        return {**asdict(self), "left_out": [*self.left_out], "corrected": [*self.corrected]}
