"""The source of the tasks of a benchmark, and digests of the content of tasks."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cache, wraps
from pathlib import Path
from typing import TypeAlias, TypeVar

from eai.base.errors import InputError, find_member
from eai.base.store import ReportProgress, Store, ignore_progress
from eai.pddl.planning import PlannerChoice, PlannerTerms
from eai.tasks.task import Task
from eai.world.vocabulary import require_tuple


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is not as it should be.

    Attributes:
        place: the file or pack that it is about; the whole where it is about all of it.
        problem: what is wrong, with the identifier where there is one.
    """

    place: str
    problem: str


T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class ErrataChoice(str, Enum):
    """Whether what is wrong in the data of a benchmark is corrected."""

    CURRENT = "current"
    NONE = "none"


def errata_choice(name: ErrataChoice | str) -> ErrataChoice:
    """The choice of this name.

    Raises:
        InputError: there is none.
    """
    return find_member(ErrataChoice, name, "choice of errata")


def planner_choice(name: PlannerChoice | str) -> PlannerChoice:
    """The choice of this name.

    Raises:
        InputError: there is none.
    """
    return find_member(PlannerChoice, name, "planner")


@dataclass(frozen=True, slots=True)
class Source:
    """The source of tasks: a store (the user's if None), who hears of a download, planner, errata."""

    store: Store | None = None
    report: ReportProgress = ignore_progress
    planner: PlannerChoice = PlannerChoice.AUTO
    errata: ErrataChoice = ErrataChoice.CURRENT
    terms: PlannerTerms = field(default_factory=PlannerTerms)


USUAL = Source()
"""The user's store, errata, and any planner."""


class TaskSet(Mapping[str, T_co]):
    """Tasks by id, in the order of the data set; each is built once, on first use.

    Args:
        task_ids: the ids, in order.
        build: builds the task of an id; its KeyError says that there is none.
        sha256: digest of the data that the tasks are made from.
    """

    def __init__(self, task_ids: Iterable[str], build: Callable[[str], T_co], sha256: str) -> None:
        self.sha256 = sha256
        self._task_ids = tuple(task_ids)
        self._build = cache(build)

    def __getitem__(self, task_id: str) -> T_co:
        return self._build(task_id)

    def __iter__(self) -> Iterator[str]:
        return iter(self._task_ids)

    def __len__(self) -> int:
        return len(self._task_ids)


OpenTasks: TypeAlias = Callable[[Source], TaskSet[T]]
"""Opens the tasks of a benchmark; the data set is fetched first if it is not there."""


def given(*tasks: Task) -> OpenTasks[Task]:
    """The opener of tasks that are written down in a program.

    Raises:
        InputError: two have one id, or one is no task.
    """
    require_tuple("eai.given", tasks, Task)
    if twice := [name for name, n in Counter(task.id for task in tasks).items() if n > 1]:
        raise InputError(f"two tasks are called {twice[0]}")
    sha256 = _digest([_content(task) for task in tasks])
    by_id = {task.id: task for task in tasks}
    opened = TaskSet(by_id, by_id.__getitem__, sha256)
    return lambda source: opened


def task_sha256(task: Task) -> str:
    """The digest of all that a task says, seen by an agent or not; the same on every machine."""
    return _digest(_content(task))


def _digest(content: object) -> str:
    return hashlib.sha256(repr(content).encode()).hexdigest()


def _content(task: Task) -> tuple[object, ...]:
    """All that a task says, as values with the same text on every machine."""
    scene = (task.scene.objects, task.scene.agent, tuple(task.initial.facts()), task.relevant)
    return (task.id, task.title, task.instruction, scene, task.goals, task.script)


def once_per_store(opener: OpenTasks[T]) -> OpenTasks[T]:
    """The opener that opens the tasks of a store once in a process; building them takes long."""
    opened: dict[Path, TaskSet[T]] = {}

    @wraps(opener)
    def open_once(source: Source) -> TaskSet[T]:
        folder = (source.store or Store()).folder
        if folder not in opened:
            opened[folder] = opener(source)
        return opened[folder]

    return open_once
