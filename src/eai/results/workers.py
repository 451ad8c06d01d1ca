"""Spreads work over long-lived processes. Results come in order, and a dead process loses no results.

Each worker receives batches and returns results through a pipe of its own; when the pipe closes, the worker
ends. The standard library's `ProcessPoolExecutor` waits for ever for a worker that is killed while it sends a
result. It also fails all batches at once, without naming the batch that killed its worker.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import islice
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.forkserver import ensure_running
from multiprocessing.pool import ExceptionWithTraceback  # type: ignore[attr-defined] # not in its stub
from multiprocessing.process import BaseProcess
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from types import FrameType
from typing import Any, TypeVar

from typing_extensions import Self

from eai.base.errors import EaiError
from eai.base.grouping import map_one_by_one
from eai.results.collector import reduce_garbage_collection

ENDED_STATUS = 128 + signal.SIGTERM
"""Exit status of a worker that ends because a signal asked it to, as in shells."""

CLEANING_SECONDS = 1
"""Seconds that a worker may take to end its planners and remove their files before it is killed."""


def run_worker(connection: Connection, folder: str) -> None:
    """Work on batches until the sender ends or closes the connection. It is the main function of a worker.

    The results of a batch are sent as one pickle. If the work raised an exception, the pickle has it instead.

    Args:
        connection: receives batches and sends results.
        folder: folder for temporary files, which another process removes.
    """
    # Ctrl-C interrupts all processes of a terminal. Workers ignore it, because the main process ends them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _raise_exit)
    tempfile.tempdir = folder
    reduce_garbage_collection()
    batches: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_queue_received_batches, args=(connection, batches), daemon=True).start()
    while True:
        result = process_pickled_batch(batches.get())
        try:
            connection.send_bytes(result)
        except OSError:  # the receiver has ended
            return


def _queue_received_batches(connection: Connection, batches: SimpleQueue[bytes]) -> None:
    """Queue incoming batches, so that the sender never waits; end this process when the connection closes."""
    try:
        while True:
            batches.put(connection.recv_bytes())
    except (EOFError, OSError):
        os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(CLEANING_SECONDS)
    os._exit(ENDED_STATUS)


def _raise_exit(number: int, frame: FrameType | None) -> None:
    """Raise SystemExit at a signal, so that planners are ended and their folders removed."""
    sys.exit(ENDED_STATUS)


def process_pickled_batch(content: bytes) -> bytes:
    """Return the pickled results of the work on a batch.

    Plain pickle is twice as fast as the connection's own pickling.
    """
    try:
        work, items = pickle.loads(content)  # noqa: S301 - of a process of this program
        return pickle.dumps(unpickle_work(work)(items))
    except Exception as error:
        return _pickle_error(error)


def _pickle_error(error: Exception) -> bytes:
    """Pickle an exception with its traceback. If this fails, pickle an EaiError with the exception's text."""
    try:
        content = pickle.dumps(ExceptionWithTraceback(error, error.__traceback__))
        pickle.loads(content)  # noqa: S301 - some exceptions can be pickled but not loaded
    except Exception:
        return pickle.dumps(EaiError(f"{type(error).__name__}: {error}"))
    return content


@lru_cache(maxsize=8)
def unpickle_work(work: bytes) -> Callable[[Sequence[Any]], Sequence[Any]]:
    """Unpickle a function that works on batches.

    The result is cached, because unpickling the function again would load its tasks again.
    """
    work_function: Callable[[Sequence[Any]], Sequence[Any]] = pickle.loads(work)  # noqa: S301 - of this program
    return work_function


T = TypeVar("T")
R = TypeVar("R")

MIN_BATCH_SIZE, MAX_BATCH_SIZE = 16, 1024
"""Number of items in a worker's first batch (small, so that each worker gets items) and largest batch."""

MAX_BATCHES_PER_WORKER = 2
"""Maximum number of batches that a worker has at a time: one in progress and one waiting.

A batch of fewer than ``MIN_BATCH_SIZE`` items, which may take minutes each, waits for a free worker.
"""

MAX_BATCHES_AHEAD = 3
"""Maximum number of batches in memory for each worker. A batch counts until its results are yielded."""

PAUSE_SECONDS = 0.01
"""Seconds between two attempts to remove a folder."""

MAX_DEATHS = 3
"""Number of worker deaths at one batch after which the batch fails."""


@dataclass(slots=True, eq=False)
class _WorkBatch:
    """A part of a stream of items, for one worker process.

    Attributes:
        work: the pickled function that works on the items.
        items: the items.
        result: the pickled results, or the pickled exception; None before they arrive.
        deaths: number of workers that died at this batch.
    """

    work: bytes
    items: Sequence[Any]
    result: bytes | None = None
    deaths: int = 0

    def results(self) -> Sequence[Any]:
        """Return the results of the function for the items of this batch, in order.

        Raises:
            Exception: the exception that the function raised.
        """
        results_or_error = pickle.loads(self.result or b"")  # noqa: S301 - of a process of this program
        if isinstance(results_or_error, Exception):
            raise results_or_error
        item_results: Sequence[Any] = results_or_error
        return item_results


@dataclass(slots=True, eq=False)
class WorkerProcess:
    """A worker process, and its batches in the order in which results will arrive."""

    process: BaseProcess
    connection: Connection
    pending: deque[_WorkBatch] = field(default_factory=deque)


class WorkerPool:
    """Worker processes that work on streams of items until the pool is closed.

    Results come in the order of the items. Only a few batches are read ahead, so memory does not grow with
    the stream. If a worker dies, its batches are done again: no item is lost or done twice. Each worker has
    its own pipe, so that no worker waits for a lock of another worker. The pipe ends with the worker. The
    pool removes temporary files of workers. A stream belongs to one thread; any number of streams may run.

    Args:
        workers: number of processes; with fewer than two, this process does the work.
    """

    def __init__(self, workers: int = 1) -> None:
        self._number = workers
        self._workers: list[WorkerProcess] = []
        self._waiting: deque[_WorkBatch] = deque()
        self._folder: TemporaryDirectory[str] | None = None

    @property
    def has_worker_processes(self) -> bool:
        """Whether worker processes do the work, not this process."""
        return self._number > 1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the workers at once, and remove their temporary files; `map_batches` starts new ones."""
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.connection.close()
            self._waiting.extend(worker.pending)
        for batch in self._waiting:
            batch.result = pickle.dumps(
                EaiError("the workers were closed before the end of the stream; take all results first")
            )
        self._waiting.clear()
        end = time.monotonic() + CLEANING_SECONDS
        for worker in workers:
            worker.process.join(max(0, end - time.monotonic()))
            worker.process.kill()
            worker.process.join()
        folder, self._folder = self._folder, None
        if folder is not None:
            _remove_folder(folder)

    def map_batches(
        self,
        work: Callable[..., Sequence[R]],
        items: Iterable[T],
        *,
        batch_sizes: tuple[int, int] = (MIN_BATCH_SIZE, MAX_BATCH_SIZE),
    ) -> Iterator[R]:
        """Yield the results of a function on the items, in their order.

        Args:
            work: computes the results of a batch of items, one for each item. It is pickled. Each worker
                unpickles it once, and keeps the last few functions.
            items: the items; they are pickled, as are results.
            batch_sizes: number of items in the first and in the largest batch of a worker.

        Raises:
            EaiError: workers die repeatedly at the same items.
        """
        if not self.has_worker_processes:
            yield from map_one_by_one(work, items)
            return
        content = pickle.dumps(work)
        upcoming = split_batches(items, self._number, *batch_sizes)
        in_progress: deque[_WorkBatch] = deque()
        try:
            while True:
                for batch_items in islice(upcoming, self._number * MAX_BATCHES_AHEAD - len(in_progress)):
                    in_progress.append(_WorkBatch(content, batch_items))
                    self._waiting.append(in_progress[-1])
                    self._send_batches()
                if not in_progress:
                    return
                while in_progress[0].result is None:
                    self._receive_result()
                yield from in_progress.popleft().results()
        finally:
            self._waiting = deque([batch for batch in self._waiting if batch not in in_progress])

    def _send_batches(self) -> None:
        """Send waiting batches to the least busy workers, until each has its maximum number of batches."""
        while self._waiting:
            batch = self._waiting[0]
            worker = self._find_least_busy_worker()
            if len(worker.pending) >= (1 if len(batch.items) < MIN_BATCH_SIZE else MAX_BATCHES_PER_WORKER):
                return
            content = pickle.dumps((batch.work, batch.items))
            worker.pending.append(self._waiting.popleft())
            with self._discard_worker_if_interrupted(worker):
                worker.connection.send_bytes(content)

    def _receive_result(self) -> None:
        """Wait for a result or for a worker's death, and send waiting batches to workers."""
        for worker in self._wait_for_workers_that_sent_or_died():
            with self._discard_worker_if_interrupted(worker):
                result = worker.connection.recv_bytes()
                worker.pending.popleft().result = result
        self._send_batches()

    def _wait_for_workers_that_sent_or_died(self) -> list[WorkerProcess]:
        """Wait until workers have sent results or died, and return these workers."""
        by_connection = {worker.connection: worker for worker in self._workers}
        return [by_connection[each] for each in wait(list(by_connection))]  # type: ignore[index] # wait() returns connections that it was given

    @contextmanager
    def _discard_worker_if_interrupted(self, worker: WorkerProcess) -> Iterator[None]:
        """Discard a worker if the block fails: the worker died, or an interrupt cut off a message."""
        try:
            yield
        except BaseException as error:
            self._discard_worker(worker)
            if not isinstance(error, EOFError | OSError):
                raise

    def _find_least_busy_worker(self) -> WorkerProcess:
        """Return an idle worker, or a new worker if more are allowed, or else the least busy worker."""
        worker_with_least = min(self._workers, key=lambda worker: len(worker.pending), default=None)
        if worker_with_least is None or (worker_with_least.pending and len(self._workers) < self._number):
            worker_with_least = self._start_worker()
            self._workers.append(worker_with_least)
        return worker_with_least

    def _start_worker(self) -> WorkerProcess:
        """Start a new process that inherits no state of this process's threads."""
        methods = multiprocessing.get_all_start_methods()
        context: Any = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
        # the fork server imports this module once for all workers
        context.set_forkserver_preload(["eai.results.batch"])
        if "forkserver" in methods:
            # the start of the resource tracker unblocks interrupts, so it comes before they are blocked
            resource_tracker.ensure_running()
            with _block_interrupts():  # workers inherit the blocked SIGINT
                ensure_running()
        if self._folder is None:
            self._folder = TemporaryDirectory(prefix="eai-workers-", ignore_cleanup_errors=True)
        connection, theirs = context.Pipe()
        with theirs:
            process = context.Process(target=run_worker, args=(theirs, self._folder.name), daemon=True)
            process.start()
        return WorkerProcess(process, connection)

    def _discard_worker(self, worker: WorkerProcess) -> None:
        """Remove a dead worker; its batches are done again, unless a batch has killed too many workers."""
        self._workers.remove(worker)
        worker.connection.close()
        worker.process.kill()
        worker.process.join()
        if not worker.pending:
            return
        current = worker.pending[0]
        current.deaths += 1
        if current.deaths == MAX_DEATHS:
            current.result = pickle.dumps(EaiError(_describe_worker_deaths(current.items)))
            worker.pending.popleft()
        self._waiting.extendleft(reversed(worker.pending))


def _remove_folder(folder: TemporaryDirectory[str]) -> None:
    """Remove the folder of temporary files of killed workers, with some retries.

    A planner that a killed worker has started may still write into the folder until it ends.
    """
    end = time.monotonic() + CLEANING_SECONDS
    folder.cleanup()
    while Path(folder.name).exists() and time.monotonic() < end:
        time.sleep(PAUSE_SECONDS)
        folder.cleanup()


def split_batches(items: Iterable[T], workers: int, first_size: int, max_size: int) -> Iterator[Sequence[T]]:
    """Yield the items in batches, whose size grows from a first size up to a maximum."""
    source, count, size = iter(items), 0, first_size
    while batch := list(islice(source, size)):
        yield batch
        count += 1
        if count % workers == 0:
            size = min(2 * size, max_size)


@contextmanager
def _block_interrupts() -> Iterator[None]:
    """Block interrupts until the ``with`` block ends. Processes started in the block never receive them."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _describe_worker_deaths(items: Sequence[Any]) -> str:
    hint = "is there enough memory, and does the program begin below `if __name__ == '__main__':`?"
    first = str(items[0])[:100]
    return f"workers died {MAX_DEATHS} times at the same {len(items)} items from {first!r} on; {hint}"
