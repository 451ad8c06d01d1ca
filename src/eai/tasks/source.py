"""The settings with which tasks of a benchmark are opened, and digests of the content of tasks."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache, wraps
from pathlib import Path
from typing import TypeAlias, TypeVar

from eai.base.errors import InputError, find_enum_member
from eai.base.store import DataPackStore, ReportProgress, ignore_progress
from eai.pddl.planning import PlannerChoice, PlannerLimits
from eai.tasks.task import Task
from eai.world.vocabulary import require_tuple


@dataclass(frozen=True, slots=True)
class DataMistake:
    """A mistake that a check found in a task file or in the data of a benchmark.

    Attributes:
        place: name of the file, pack (file of downloaded data), task or benchmark with the mistake.
        problem: the mistake in words, with the id of the task if it concerns one task.
    """

    place: str
    problem: str


T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class ErrataChoice(str, Enum):
    """The choice whether known errors in a benchmark's data are corrected."""

    CURRENT = "current"
    NONE = "none"


def find_errata_choice(name: ErrataChoice | str) -> ErrataChoice:
    """Return the `ErrataChoice` of a name.

    Raises:
        InputError: no choice has this name.
    """
    return find_enum_member(ErrataChoice, name, "choice of errata")


def find_planner_choice(name: PlannerChoice | str) -> PlannerChoice:
    """Return the `PlannerChoice` of a name.

    Raises:
        InputError: no choice has this name.
    """
    return find_enum_member(PlannerChoice, name, "planner")


@dataclass(frozen=True, slots=True)
class Source:
    """The settings with which the tasks of a benchmark are opened.

    Attributes:
        store: the folder of downloaded data; the user's default folder if None.
        report: receives the progress of a download.
        planner: the planner that tests the operators of answers.
        errata: whether known errors in the data are corrected.
        terms: the limits of planners on time and memory.
        kept: the maximum number of built tasks that a task file keeps in memory; None to keep all.
    """

    store: DataPackStore | None = None
    report: ReportProgress = ignore_progress
    planner: PlannerChoice = PlannerChoice.AUTO
    errata: ErrataChoice = ErrataChoice.CURRENT
    terms: PlannerLimits = field(default_factory=PlannerLimits)
    kept: int | None = None


USUAL_SOURCE = Source()
"""The default settings for opening tasks: the user's store of data, current errata, any available planner."""


class TaskSet(Mapping[str, T_co]):
    """A mapping from ids to tasks, in the order of the data set. A task is built on first use, and kept.

    Args:
        task_ids: the ids of the tasks, in order.
        build: returns the task with an id. It raises KeyError for an unknown id.
        sha256: SHA-256 digest of the data from which the tasks are built.
        max_kept: maximum number of tasks that are kept, the last ones used; None to keep all.
    """

    def __init__(
        self, task_ids: Iterable[str], build: Callable[[str], T_co], sha256: str, max_kept: int | None = None
    ) -> None:
        self.sha256 = sha256
        self._task_ids = tuple(task_ids)
        self._build = lru_cache(max_kept)(build)

    def __getitem__(self, task_id: str) -> T_co:
        return self._build(task_id)

    def __iter__(self) -> Iterator[str]:
        return iter(self._task_ids)

    def __len__(self) -> int:
        return len(self._task_ids)


OpenTasks: TypeAlias = Callable[[Source], TaskSet[T]]
"""Function that opens the tasks of a benchmark with given settings. It downloads data that is missing."""


def use_tasks(*tasks: Task) -> OpenTasks[Task]:
    """Return a function that returns the given tasks; a benchmark can have it in place of a data set.

    Raises:
        InputError: two tasks have the same id, or an argument is not a task.
    """
    require_tuple("eai.use_tasks", tasks, Task)
    if twice := [name for name, n in Counter(task.id for task in tasks).items() if n > 1]:
        raise InputError(f"two tasks are called {twice[0]}: give each task an id of its own")
    sha256 = _compute_sha256_of_repr([_list_task_content(task) for task in tasks])
    by_id = {task.id: task for task in tasks}
    opened = TaskSet(by_id, by_id.__getitem__, sha256)
    return lambda source: opened


def compute_task_sha256(task: Task) -> str:
    """Return the SHA-256 digest of a task's content, which is equal on every machine.

    The content includes data that no agent sees, such as the task's own plan.
    """
    return _compute_sha256_of_repr(_list_task_content(task))


def _compute_sha256_of_repr(content: object) -> str:
    return hashlib.sha256(repr(content).encode()).hexdigest()


def _list_task_content(task: Task) -> tuple[object, ...]:
    """Return the content of a task as values whose `repr` is equal on every machine."""
    scene = (task.scene.objects, task.scene.agent, tuple(task.initial.facts()), task.relevant)
    return (task.id, task.title, task.instruction, scene, task.goals, task.script)


def cache_opened_tasks_per_data_folder(opener: OpenTasks[T]) -> OpenTasks[T]:
    """Return a function that opens the tasks of a data store once in a process; building tasks takes long."""
    opened: dict[Path, TaskSet[T]] = {}

    @wraps(opener)
    def open_task_set_once(source: Source) -> TaskSet[T]:
        folder = (source.store or DataPackStore()).folder
        if folder not in opened:
            opened[folder] = opener(source)
        return opened[folder]

    return open_task_set_once
