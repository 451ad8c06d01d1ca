"""Score answers with actors of a Ray cluster instead of processes of this machine."""

from __future__ import annotations

import pickle
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeVar

import ray
from ray.exceptions import RayActorError

from eai.base.errors import EaiError, InputError
from eai.results.batch import Scoring
from eai.results.workers import (
    MAX_BATCH_SIZE,
    MAX_BATCHES_AHEAD,
    MAX_BATCHES_PER_WORKER,
    MAX_DEATHS,
    MIN_BATCH_SIZE,
    split_batches,
    unpickle_work,
)

LOCAL = "local"
"""Address that stands for a new cluster on this machine, which ends with the program."""

T = TypeVar("T")
R = TypeVar("R")


class RayScoring(Scoring):
    """Scores streams of answers with actors (worker processes) of a Ray cluster.

    Records equal those of a single process, byte for byte. Each actor keeps its tasks in memory. If an actor
    dies, it is started again and its batch is scored again. Each node needs the same version of this package,
    and fetches the data set if it is missing.

    Args:
        address: Address of the cluster for `ray.init`: ``auto``, ``HOST:6379``, ``ray://HOST:10001``, or
            ``local`` for a new cluster on this machine. A program inside a cluster uses that cluster.
        workers: Number of actors, with one core each.

    Raises:
        InputError: No cluster answers, or the cluster has fewer cores than actors.
    """

    def __init__(self, address: str, workers: int) -> None:
        super().__init__(workers)
        self._is_ours = not ray.is_initialized()
        if self._is_ours:
            _connect_to_cluster(address, workers)
        cores = int(ray.cluster_resources().get("CPU", 0))
        if cores < workers:
            self._leave_cluster()
            raise InputError(
                f"{address}: {workers} workers need {workers} cores, but the cluster has {cores}"
            )
        lasting = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=MAX_DEATHS - 1)(_BatchActor)
        self._actors = [lasting.remote() for _ in range(workers)]

    def close(self) -> None:
        """End the actors, and leave the cluster if this object joined it."""
        for actor in self._actors:
            ray.kill(actor)
        self._leave_cluster()

    def _leave_cluster(self) -> None:
        if self._is_ours:
            ray.shutdown()

    def map_batches(
        self,
        work: Callable[..., Sequence[R]],
        items: Iterable[T],
        *,
        batch_sizes: tuple[int, int] = (MIN_BATCH_SIZE, MAX_BATCH_SIZE),
    ) -> Iterator[R]:
        """Yield a function's results on the items, in order.

        Each batch of items goes to the actor with the fewest unfinished batches.

        Raises:
            EaiError: Actors die repeatedly while they work on one batch.
        """
        content = ray.put(pickle.dumps(work))
        ahead: deque[Any] = deque()
        running: dict[Any, int] = {}  # maps each unfinished batch to the number of its actor
        for batch in split_batches(items, self._number, *batch_sizes):
            if len(running) == self._number * MAX_BATCHES_PER_WORKER:
                for done in ray.wait([*running])[0]:
                    del running[done]
            batches = Counter(running.values())
            idlest = min(range(self._number), key=lambda number: batches[number])
            ahead.append(self._actors[idlest].run.remote(content, pickle.dumps(batch)))
            running[ahead[-1]] = idlest
            if len(ahead) == self._number * MAX_BATCHES_AHEAD:
                yield from _get_results(ahead.popleft())
        while ahead:
            yield from _get_results(ahead.popleft())


def _connect_to_cluster(address: str, workers: int) -> None:
    settings = {"num_cpus": workers} if address == LOCAL else {}
    try:
        ray.init(address, log_to_driver=False, logging_level="error", **settings)
    except (ConnectionError, ValueError) as error:
        raise InputError(
            f"{address}: no Ray cluster answers; start one, or give {LOCAL} ({error})"
        ) from error


def _get_results(promise: Any) -> Sequence[Any]:
    try:
        results: Sequence[Any] = pickle.loads(ray.get(promise))  # noqa: S301 - written by an actor of this program
    except RayActorError as error:
        raise EaiError(
            f"actors died {MAX_DEATHS} times at the same answers; is there enough memory?"
        ) from error
    return results


class _BatchActor:
    """A process on a node of the cluster that applies functions to batches."""

    def run(self, work: bytes, items: bytes) -> bytes:
        """Apply a pickled function to a pickled batch, and return the pickled results."""
        return pickle.dumps(unpickle_work(work)(pickle.loads(items)))  # noqa: S301 - written by this program
