"""Score answers with actors of a Ray cluster instead of processes of this machine."""

from __future__ import annotations

import os
import socket
import sys
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any, cast
from urllib.parse import urlsplit

import ray
from ray.exceptions import RayError

from eai.base.errors import InputError
from eai.results.batch import Scoring
from eai.results.workers import WorkerProcess, process_pickled_batch

LOCAL = "local"
"""Address of a new cluster on this machine. The cluster ends when the program ends."""

_PORT_SECONDS = 5
"""Seconds in which the port of a cluster must accept a connection. Ray itself tries for 14 minutes."""

_MAX_CONNECTION_ATTEMPTS_VARIABLE = "RAY_gcs_server_port_wait_time_s"
"""Environment variable with the maximum number of Ray's tries to connect, one a second (default 20)."""


class RayScoring(Scoring):
    """Scores streams of answers with actors (worker processes) of a Ray cluster.

    Records equal those of a single process, byte for byte. Each actor keeps its tasks in memory. If an actor
    or its node dies, other actors do its batches again. A new actor starts when the cluster has a free core.
    Each node needs the same version of this package, and fetches the data set if it is missing.

    Args:
        address: Address of the cluster for `ray.init`: ``auto``, ``HOST:6379``, ``ray://HOST:10001``, or
            ``local`` for a new cluster on this machine. A program inside a cluster uses that cluster.
        workers: Number of actors, with one core each; None for one on each core of the cluster.

    Raises:
        InputError: No cluster answers, or the cluster has fewer cores than actors.
    """

    def __init__(self, address: str, workers: int | None = None) -> None:
        self._is_ours = not ray.is_initialized()
        if self._is_ours:
            _connect_to_cluster(address, workers)
        cores = int(ray.cluster_resources().get("CPU", 0))
        if not cores:
            self._leave_cluster()
            raise InputError(f"{address}: the cluster has no processor cores; add a node that has cores")
        number = cores if workers is None else workers
        if cores < number:
            self._leave_cluster()
            raise InputError(f"{address}: {number} workers need {number} cores, but the cluster has {cores}")
        super().__init__(number)

    @property
    def has_worker_processes(self) -> bool:
        """True: actors in other processes do the work, even if there is only one actor."""
        return True

    def close(self) -> None:
        """End the actors, and leave the cluster if this object joined it."""
        super().close()
        self._leave_cluster()

    def _leave_cluster(self) -> None:
        if self._is_ours:
            ray.shutdown()

    def _start_worker(self) -> WorkerProcess:
        actor: Any = _ClusterWorker()
        return WorkerProcess(actor, actor)

    def _find_least_busy_worker(self) -> WorkerProcess:
        """Return the least busy running actor, after starting new actors if there are fewer than batches.

        An actor that still waits for a free core is not running, so it gets no batch.
        """
        batches = len(self._waiting) + sum(len(worker.pending) for worker in self._workers)
        while len(self._workers) < min(self._number, batches):
            self._workers.append(self._start_worker())
        while not (running := [worker for worker in self._workers if _get_actor(worker).is_running()]):
            ray.wait([_get_actor(worker).reference_to_wait_for for worker in self._workers])
        return min(running, key=lambda worker: len(worker.pending))

    def _wait_for_workers_that_sent_or_died(self) -> list[WorkerProcess]:
        """Wait until an actor has a result, dies or begins to run.

        Return the actors that have a result or died. The list is empty if an actor only began to run.
        """
        by_promise = {_get_actor(worker).reference_to_wait_for: worker for worker in self._workers}
        by_promise.pop(None, None)
        ready = [by_promise[promise] for promise in ray.wait([*by_promise])[0]]
        return [worker for worker in ready if _get_actor(worker).is_running() and worker.pending]


def _connect_to_cluster(address: str, workers: int | None) -> None:
    settings = {"num_cpus": workers} if address == LOCAL else {}
    with TemporaryFile() as ray_output:
        try:
            _require_open_port(address)
            with (
                _redirect_standard_error(ray_output),
                nullcontext() if address == LOCAL else _limit_connection_attempts(),
            ):
                ray.init(address, log_to_driver=False, logging_level="error", **settings)
        except (OSError, ValueError, RayError) as error:
            ray_output.seek(0)
            text = ray_output.read().decode()
            raise InputError(_describe_connection_failure(address, error, text)) from error


def _require_open_port(address: str) -> None:
    """Raise if no program listens at an address with a port."""
    parts = urlsplit(address if "://" in address else f"//{address}")
    if parts.hostname and parts.port:
        socket.create_connection((parts.hostname, parts.port), _PORT_SECONDS).close()


@contextmanager
def _redirect_standard_error(file: IO[bytes]) -> Iterator[None]:
    """Write what Ray's C++ code prints in a ``with`` block to a file. Print it after the block succeeds."""
    sys.stderr.flush()
    before = os.dup(2)
    os.dup2(file.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(before, 2)
        os.close(before)
    file.seek(0)
    os.write(2, file.read())


@contextmanager
def _limit_connection_attempts() -> Iterator[None]:
    is_ours = _MAX_CONNECTION_ATTEMPTS_VARIABLE not in os.environ
    os.environ.setdefault(_MAX_CONNECTION_ATTEMPTS_VARIABLE, "2")
    try:
        yield
    finally:
        if is_ours:
            del os.environ[_MAX_CONNECTION_ATTEMPTS_VARIABLE]


def _describe_connection_failure(address: str, error: Exception, ray_output: str) -> str:
    if "authenticat" in f"{error} {ray_output}".lower():
        return (
            f"{address}: the cluster expects its token; set RAY_AUTH_MODE=token, and RAY_AUTH_TOKEN to the "
            "content of ~/.ray/auth_token on its head node"
        )
    return f"{address}: no Ray cluster answers; start one, or give {LOCAL} ({error})"


def _get_actor(worker: WorkerProcess) -> _ClusterWorker:
    return cast("_ClusterWorker", worker.connection)


class _ClusterWorker:
    """A Ray actor, with the methods that `WorkerPool` calls on a process and on its connection."""

    def __init__(self) -> None:
        self._actor = ray.remote(num_cpus=1)(_BatchActor).remote()
        self._start: Any = self._actor.enter_folder_of_calling_process.remote(str(Path.cwd()))
        self._results: deque[Any] = deque()

    @property
    def reference_to_wait_for(self) -> Any:
        """The Ray reference to the actor's start, or to its next result; None if the actor is idle."""
        return self._start or (self._results[0] if self._results else None)

    def is_running(self) -> bool:
        """Whether the actor waits no longer for a processor core, because it got one or died."""
        if self._start is not None and ray.wait([self._start], timeout=0)[0]:
            self._start = None
        return self._start is None

    def send_bytes(self, content: bytes) -> None:
        self._results.append(self._actor.apply_pickled_function_to_batch.remote(content))

    def recv_bytes(self) -> bytes:
        """Return the next result.

        Raises:
            EOFError: The actor or its node died.
        """
        try:
            result: bytes = ray.get(self._results.popleft())
        except RayError as error:
            raise EOFError from error
        return result

    def close(self) -> None:
        ray.kill(self._actor)

    def kill(self) -> None:
        """Do nothing: `close` has ended the actor."""

    def join(self, timeout: float | None = None) -> None:
        """Do nothing: Ray waits for its processes."""


class _BatchActor:
    """A process on a node of the cluster that applies functions to batches."""

    def enter_folder_of_calling_process(self, folder: str) -> None:
        """Make ``folder`` the working folder of this process, if this machine has the folder.

        It is the working folder of the process that made this actor. Then a relative path names the same file
        in both processes.
        """
        with suppress(OSError):  # a machine of the cluster may lack the folder
            os.chdir(folder)

    def apply_pickled_function_to_batch(self, pickled_function_and_batch: bytes) -> bytes:
        """Apply a pickled function to a pickled batch, and return the pickled results."""
        return process_pickled_batch(pickled_function_and_batch)
