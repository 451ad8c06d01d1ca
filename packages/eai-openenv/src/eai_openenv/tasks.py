"""The tasks that a server plays and rewards. Tasks of other benchmarks are refused."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from itertools import combinations

from eai.abilities.protocol import Ability
from eai.base.errors import InputError
from eai.benchmarks.generator.sets import SHARES, fingerprint_task
from eai.benchmarks.names import TaskReference
from eai.results.reward import open_reward_suite
from eai.tasks.task import Task


class Tasks:
    """The tasks of some benchmarks, by split.

    A task of another benchmark is refused, because a search for it could import a module or open a file.

    Args:
        splits: Benchmark of each split, as `eai.open` takes it. The benchmarks are opened at once.

    Raises:
        InputError: There is no split, a benchmark does not exist or has no task that can be played, or two of
            train, validation and test have common goals.
        DataError: The data is not available.
    """

    def __init__(self, splits: Mapping[str, str]) -> None:
        if not splits:
            raise InputError("no benchmark: name at least one to serve")
        self._benchmarks = frozenset(splits.values())
        self._tasks_by_split: dict[str, Mapping[str, Task]] = {}
        for split, benchmark in splits.items():
            suite = open_reward_suite(benchmark, Ability.ACTION_SEQUENCING)
            playable = {
                f"{benchmark}/{suite.ability.value}/{task_id}": suite.tasks[task_id]
                for task_id in suite.task_ids
                if suite.tasks[task_id].unplannable_reason is None
            }
            if not playable:
                raise InputError(f"{benchmark} has no task that can be played")
            self._tasks_by_split[split] = playable
        self._references_by_split = {
            split: tuple(playable) for split, playable in self._tasks_by_split.items()
        }
        self._refuse_common_goals()

    def _refuse_common_goals(self) -> None:
        """Raise if two splits with names of `eai generate` have common goals."""
        goals = {
            split: {fingerprint_task(task)[0] for task in self._tasks_by_split[split].values()}
            for split in SHARES
            if split in self._tasks_by_split
        }
        for one, other in combinations(goals, 2):
            if common := goals[one] & goals[other]:
                problem = f"{one.value} and {other.value} have {len(common)} goals in common"
                raise InputError(f"{problem}: see eai check --against, or rename the splits")

    @property
    def splits(self) -> Sequence[str]:
        """Names of the splits, in order."""
        return tuple(self._references_by_split)

    def list_references(self, split: str) -> Sequence[str]:
        """Return the tasks of a split that can be played, in the order of the data set.

        Raises:
            IndexError: The split does not exist.
        """
        if split not in self._references_by_split:
            raise IndexError(f"unknown split {split!r}: expected one of {', '.join(self.splits)}")
        return self._references_by_split[split]

    def get_instruction(self, split: str, task: str) -> str:
        """Return the instruction of a task."""
        return self._tasks_by_split[split][task].instruction

    def require_served_task(self, task: str) -> str:
        """Return the reference of a task if the server has its benchmark.

        Raises:
            InputError: The server does not have the benchmark.
        """
        if TaskReference.parse(task).benchmark not in self._benchmarks:
            served = ", ".join(sorted(self._benchmarks))
            raise InputError(f"{task[:200]!r}: this server has no such benchmark; expected one of {served}")
        return task

    def choose_task(self, task: str | None, split: str | None, index: int | None, seed: int | None) -> str:
        """Return the reference of the named task, of a task by its index, or of a random task of a split.

        Raises:
            InputError: The task does not exist.
        """
        if task is not None:
            return self.require_served_task(task)
        name = split or self.splits[0]
        if name not in self._references_by_split:
            raise InputError(f"unknown split {name!r}: expected one of {', '.join(self.splits)}")
        tasks = self._references_by_split[name]
        if index is None:
            return random.Random(seed).choice(tasks)  # noqa: S311 - chance, not secrets
        if not 0 <= index < len(tasks):
            raise InputError(f"no task {index} in split {name}: expected 0 to {len(tasks) - 1}")
        return tasks[index]
