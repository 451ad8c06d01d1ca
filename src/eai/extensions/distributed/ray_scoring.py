"""Score answers with actors of a Ray cluster instead of processes of this machine."""

from __future__ import annotations

import os
import pickle
import socket
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from tempfile import TemporaryFile
from typing import IO, Any, TypeVar
from urllib.parse import urlsplit

import ray
from ray.exceptions import RayActorError, RayError

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

_PORT_SECONDS = 5
"""Seconds in which the port of a cluster must accept a connection. Ray itself tries for 14 minutes."""

_MAX_ATTEMPTS = "RAY_gcs_server_port_wait_time_s"
"""Environment variable that limits how often Ray tries to connect, once a second. Ray's default is 20."""

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

    @property
    def has_processes(self) -> bool:
        """True: actors do the work, even if there is one."""
        return True

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
    with TemporaryFile() as lines:
        try:
            _require_open_port(address)
            with _redirect_standard_error(lines), nullcontext() if address == LOCAL else _limit_attempts():
                ray.init(address, log_to_driver=False, logging_level="error", **settings)
        except (OSError, ValueError, RayError) as error:
            lines.seek(0)
            raise InputError(_describe_failure(address, error, lines.read().decode())) from error


def _require_open_port(address: str) -> None:
    """Raise if no program listens at an address with a port."""
    parts = urlsplit(address if "://" in address else f"//{address}")
    if parts.hostname and parts.port:
        socket.create_connection((parts.hostname, parts.port), _PORT_SECONDS).close()


@contextmanager
def _redirect_standard_error(lines: IO[bytes]) -> Iterator[None]:
    """Write what Ray's C++ code prints in a ``with`` block to a file. Print it after the block succeeds."""
    sys.stderr.flush()
    before = os.dup(2)
    os.dup2(lines.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)
    lines.seek(0)
    os.write(2, lines.read())


@contextmanager
def _limit_attempts() -> Iterator[None]:
    is_ours = _MAX_ATTEMPTS not in os.environ
    os.environ.setdefault(_MAX_ATTEMPTS, "2")
    try:
        yield
    finally:
        if is_ours:
            del os.environ[_MAX_ATTEMPTS]


def _describe_failure(address: str, error: Exception, lines: str) -> str:
    if "authenticat" in f"{error} {lines}".lower():
        return (
            f"{address}: the cluster expects its token; set RAY_AUTH_MODE=token, and RAY_AUTH_TOKEN to the "
            "content of ~/.ray/auth_token on its head node"
        )
    return f"{address}: no Ray cluster answers; start one, or give {LOCAL} ({error})"


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
