"""Scoring with Ray: by actors of a cluster in the place of processes, and as a step of Ray Data.

The step takes batches of answers and returns the same with their records.
"""

from __future__ import annotations

import pickle
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import ray
from ray.exceptions import RayActorError

from eai.abilities.responses import COLUMNS, Response
from eai.benchmark.suite import Suite
from eai.errors import InputError, WorkerError
from eai.scoring.batch import Scoring
from eai.scoring.records import line_of
from eai.scoring.worker import loaded
from eai.scoring.workers import AHEAD, DEATHS, LARGEST, SMALLEST, batches

RECORD = "record"
"""The column that is added."""


class Scores:
    """What `ray.data.Dataset.map_batches` is given to score the rows of a data set.

    Ray makes it once in each actor, which keeps the tasks that it has made; a batch whose actor dies is done
    again by another one. It needs nothing of Ray's itself.

    Args:
        suite: the tasks, opened by name, for these answers (`Suite.over`); an actor opens them again.
        model: who answered.
        explanations: put the step-by-step explanation into each record.
    """

    def __init__(self, suite: Suite, model: str, *, explanations: bool = False) -> None:
        self._suite = suite
        self._model = model
        self._explanations = explanations

    def __call__(self, batch: Mapping[str, Sequence[Any]]) -> dict[str, Sequence[Any]]:
        """The batch with the column ``record``: for each answer what its line in ``records.jsonl`` would be.

        It is null for tasks that are known not to be in the data set, whose rows a response file may have.

        Args:
            batch: columns by name: ``identifier`` and ``llm_output``, as in response files, and any others.

        Raises:
            InputError: one of the two is missing, or there is no such task.
        """
        if not batch.keys() >= set(COLUMNS):
            raise InputError(f"expected the columns {' and '.join(COLUMNS)}, found {', '.join(batch)}")
        identifiers, texts = (batch[column] for column in COLUMNS)
        task_ids = [self._suite.benchmark.task_id_of(str(identifier)) for identifier in identifiers]
        answers = [
            Response(task_id, str(text or ""))
            for task_id, text in zip(task_ids, texts, strict=True)
            if task_id is not None
        ]
        records = Scoring().records(self._suite, self._model, answers, explanations=self._explanations)
        lines = [None if task_id is None else line_of(next(records)) for task_id in task_ids]
        return {**batch, RECORD: lines}


LOCAL = "local"
"""The address of a cluster that is started on this machine, and ends with the program."""

T = TypeVar("T")
R = TypeVar("R")


class RayScoring(Scoring):
    """Scores streams of answers with actors of a cluster; records are those of one process, byte for byte.

    Each actor keeps the tasks that it has made. One that dies is started again, and what it was at is done
    again. This package, of this version, has to be installed on the nodes, each of which fetches the data set
    by itself where it does not have it.

    Args:
        address: of the cluster, as `ray.init` takes it: ``auto``, ``HOST:6379``, ``ray://HOST:10001``, or
            ``local`` for one of this machine alone. A program that is part of a cluster stays in that.
        workers: how many actors, of one core each.

    Raises:
        InputError: no cluster answers, or it has fewer cores.
    """

    def __init__(self, address: str, workers: int) -> None:
        super().__init__(workers)
        self._is_ours = not ray.is_initialized()
        if self._is_ours:
            _connect(address, workers)
        cores = int(ray.cluster_resources().get("CPU", 0))
        if cores < workers:
            self._leave()
            raise InputError(f"{address}: {workers} workers take as many cores, and the cluster has {cores}")
        lasting = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=DEATHS - 1)(_Actor)
        self._actors = [lasting.remote() for _ in range(workers)]

    def close(self) -> None:
        """End the actors, and leave the cluster where the program was not part of it before."""
        for actor in self._actors:
            ray.kill(actor)
        self._leave()

    def _leave(self) -> None:
        if self._is_ours:
            ray.shutdown()

    def each(
        self,
        work: Callable[..., Sequence[R]],
        items: Iterable[T],
        *,
        at_a_time: tuple[int, int] = (SMALLEST, LARGEST),
    ) -> Iterator[R]:
        """What a function makes of the items, in their order.

        Raises:
            WorkerError: actors die whenever they come to certain items.
        """
        content = ray.put(pickle.dumps(work))
        ahead: deque[Any] = deque()
        for number, batch in enumerate(batches(items, self._number, *at_a_time)):
            actor = self._actors[number % self._number]
            ahead.append(actor.done.remote(content, pickle.dumps(batch)))
            if len(ahead) == self._number * AHEAD:
                yield from _results(ahead.popleft())
        while ahead:
            yield from _results(ahead.popleft())


def _connect(address: str, workers: int) -> None:
    here = {"num_cpus": workers} if address == LOCAL else {}
    try:
        ray.init(address, log_to_driver=False, logging_level="error", **here)
    except (ConnectionError, ValueError) as error:
        raise InputError(f"{address}: no cluster of Ray's answers ({error})") from error


def _results(promised: Any) -> Sequence[Any]:
    try:
        found: Sequence[Any] = pickle.loads(ray.get(promised))  # noqa: S301 - of an actor of this program
    except RayActorError as error:
        raise WorkerError(
            f"actors died {DEATHS} times at the same answers; is there enough memory?"
        ) from error
    return found


class _Actor:
    """What works on a node."""

    def done(self, work: bytes, items: bytes) -> bytes:
        """What some work makes of a batch."""
        return pickle.dumps(loaded(work)(pickle.loads(items)))  # noqa: S301 - of the program that started it
