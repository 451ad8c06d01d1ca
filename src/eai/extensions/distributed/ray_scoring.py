"""Scoring by actors of a Ray cluster, in the place of processes of this machine."""

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
    load_work,
    split_batches,
)

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
        lasting = ray.remote(num_cpus=1, max_restarts=-1, max_task_retries=MAX_DEATHS - 1)(_Actor)
        self._actors = [lasting.remote() for _ in range(workers)]

    def close(self) -> None:
        """End the actors, and leave the cluster where the program was not part of it before."""
        for actor in self._actors:
            ray.kill(actor)
        self._leave()

    def _leave(self) -> None:
        if self._is_ours:
            ray.shutdown()

    def map_batches(
        self,
        work: Callable[..., Sequence[R]],
        items: Iterable[T],
        *,
        batch_sizes: tuple[int, int] = (MIN_BATCH_SIZE, MAX_BATCH_SIZE),
    ) -> Iterator[R]:
        """Yield the results of a function on the items, in their order; a batch goes to who has least to do.

        Raises:
            EaiError: actors die whenever they come to certain items.
        """
        content = ray.put(pickle.dumps(work))
        ahead: deque[Any] = deque()
        doing: dict[Any, int] = {}  # what is promised and not known to be done -> which actor has it
        for batch in split_batches(items, self._number, *batch_sizes):
            if len(doing) == self._number * MAX_BATCHES_PER_WORKER:
                for done in ray.wait([*doing])[0]:
                    del doing[done]
            held = Counter(doing.values())
            idlest = min(range(self._number), key=lambda number: held[number])
            ahead.append(self._actors[idlest].done.remote(content, pickle.dumps(batch)))
            doing[ahead[-1]] = idlest
            if len(ahead) == self._number * MAX_BATCHES_AHEAD:
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
        raise EaiError(
            f"actors died {MAX_DEATHS} times at the same answers; is there enough memory?"
        ) from error
    return found


class _Actor:
    """An actor on a node."""

    def done(self, work: bytes, items: bytes) -> bytes:
        """Do some work on a batch."""
        return pickle.dumps(load_work(work)(pickle.loads(items)))  # noqa: S301 - of the program that started it
