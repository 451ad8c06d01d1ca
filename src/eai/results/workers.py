"""Work spread over processes that stay: results in order, and a process that dies costs nothing but time.

To a worker batches come through a pipe of its own, and results leave through it; without it the worker ends.
The standard library's pools do not keep this: `ProcessPoolExecutor` waits for ever for a worker that is
killed while it sends a result, and fails all batches at once without saying which killed its worker.
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
from eai.results.collector import collect_seldom

ENDED = 128 + signal.SIGTERM
"""The exit status of a worker that is ended, as a shell has it."""

CLEANING_SECONDS = 1
"""How long a worker may take to end its planners and to remove their files before it is killed."""


def serve(connection: Connection, folder: str) -> None:
    """Do what comes, until whoever sends it has ended or is done with this process.

    Results are sent as one pickle a batch: the results, or the exception that there was.

    Args:
        connection: where batches come from, and where results go.
        folder: where temporary files are made, which another process removes.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal interrupts all processes at once
    signal.signal(signal.SIGTERM, _end)
    tempfile.tempdir = folder
    collect_seldom()
    given: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_receive, args=(connection, given), daemon=True).start()
    while True:
        result = _done(given.get())
        try:
            connection.send_bytes(result)
        except OSError:  # nobody is there to read it
            return


def _receive(connection: Connection, given: SimpleQueue[bytes]) -> None:
    """Take what comes while the worker is at work, so that who sends never waits; then end the process."""
    try:
        while True:
            given.put(connection.recv_bytes())
    except (EOFError, OSError):
        os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(CLEANING_SECONDS)
    os._exit(ENDED)


def _end(number: int, frame: FrameType | None) -> None:
    """End as an exception does, so that planners are ended and their folders removed."""
    sys.exit(ENDED)


def _done(content: bytes) -> bytes:
    """The results of some work on a batch, pickled plainly: as a connection does it takes twice as long."""
    try:
        work, items = pickle.loads(content)  # noqa: S301 - of a process of this program
        return pickle.dumps(load_work(work)(items))
    except Exception as error:
        return _error_bytes(error)


def _error_bytes(error: Exception) -> bytes:
    """An exception with its traceback, to be raised elsewhere; in words if it cannot be sent."""
    try:
        content = pickle.dumps(ExceptionWithTraceback(error, error.__traceback__))
        pickle.loads(content)  # noqa: S301 - some can be pickled and not loaded
    except Exception:
        return pickle.dumps(EaiError(f"{type(error).__name__}: {error}"))
    return content


@lru_cache(maxsize=8)
def load_work(work: bytes) -> Callable[[Sequence[Any]], Sequence[Any]]:
    """Work as it was pickled; opening the tasks that it is about takes long."""
    known: Callable[[Sequence[Any]], Sequence[Any]] = pickle.loads(work)  # noqa: S301 - of this program
    return known


T = TypeVar("T")
R = TypeVar("R")

MIN_BATCH_SIZE, MAX_BATCH_SIZE = 16, 1024
"""How many items a worker is given at a time: few at first, so that all have some, then more."""

MAX_BATCHES_PER_WORKER = 2
"""How many batches a worker has at most: one that it is at, and one to go on with.

One of fewer than ``SMALLEST`` items, where each may take minutes, waits for who is free first.
"""

MAX_BATCHES_AHEAD = 3
"""For how many batches a worker there may be at a time, those included whose results are not yet taken."""

PAUSE_SECONDS = 0.01
"""Seconds until a folder is looked at again."""

MAX_DEATHS = 3
"""How often workers may die at a batch."""


@dataclass(slots=True, eq=False)
class _Batch:
    """Some items of a stream, the pickled work to do on them, and what becomes of them."""

    work: bytes
    items: Sequence[Any]
    result: bytes | None = None
    deaths: int = 0

    def results(self) -> Sequence[Any]:
        """The results of the items.

        Raises:
            Exception: that which the work raised.
        """
        found = pickle.loads(self.result or b"")  # noqa: S301 - of a process of this program
        if isinstance(found, Exception):
            raise found
        results: Sequence[Any] = found
        return results


@dataclass(slots=True, eq=False)
class _Worker:
    """A process, and the batches that it has, in the order in which their results will come."""

    process: BaseProcess
    connection: Connection
    has: deque[_Batch] = field(default_factory=deque)


class Workers:
    """Processes that do work on streams of items, and stay until they are closed.

    Results come in the order of the items. No more than a few batches are read ahead, so that memory does not
    grow with the stream. What a worker that dies was at is done again: nothing is lost, nothing comes twice.
    Each worker has a pipe of its own, which ends with it, so that none waits for what another holds; what
    they leave in temporary folders is removed here. Streams are for one thread, any number of them at a time.

    Args:
        workers: how many processes to use; this one alone if fewer than two.
    """

    def __init__(self, workers: int = 1) -> None:
        self._number = workers
        self._workers: list[_Worker] = []
        self._waiting: deque[_Batch] = deque()
        self._folder: TemporaryDirectory[str] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the workers, whatever they do, and remove what they leave; another stream starts others."""
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.connection.close()
            self._waiting.extend(worker.has)
        for batch in self._waiting:
            batch.result = pickle.dumps(EaiError("the workers were closed before the stream came to its end"))
        self._waiting.clear()
        end = time.monotonic() + CLEANING_SECONDS
        for worker in workers:
            worker.process.join(max(0, end - time.monotonic()))
            worker.process.kill()
            worker.process.join()
        folder, self._folder = self._folder, None
        if folder is not None:
            _remove(folder)

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
                loads it once, as long as it is among the last few functions.
            items: the items; they are pickled, as are results.
            batch_sizes: number of items in the first and in the largest batch of a worker.

        Raises:
            EaiError: workers die repeatedly at the same items.
        """
        if self._number < 2:
            for item in items:
                yield from work((item,))
            return
        content = pickle.dumps(work)
        coming = split_batches(items, self._number, *batch_sizes)
        ahead: deque[_Batch] = deque()
        try:
            while True:
                for part in islice(coming, self._number * MAX_BATCHES_AHEAD - len(ahead)):
                    ahead.append(_Batch(content, part))
                    self._waiting.append(ahead[-1])
                    self._give()
                if not ahead:
                    return
                while ahead[0].result is None:
                    self._receive()
                yield from ahead.popleft().results()
        finally:
            self._waiting = deque([batch for batch in self._waiting if batch not in ahead])

    def _give(self) -> None:
        """Send batches that wait to those who have least, as far as they may have more."""
        while self._waiting:
            batch = self._waiting[0]
            worker = self._least_busy()
            if len(worker.has) >= (1 if len(batch.items) < MIN_BATCH_SIZE else MAX_BATCHES_PER_WORKER):
                return
            content = pickle.dumps((batch.work, batch.items))
            worker.has.append(self._waiting.popleft())
            with self._buried_if_cut_off(worker):
                worker.connection.send_bytes(content)

    def _receive(self) -> None:
        """Wait until there is a result, or a worker dies, and give out what waits."""
        by_connection = {worker.connection: worker for worker in self._workers}
        for connection in wait(list(by_connection)):
            worker = by_connection[connection]  # type: ignore[index] # one of those that it was given
            with self._buried_if_cut_off(worker):
                result = worker.connection.recv_bytes()
                worker.has.popleft().result = result
        self._give()

    @contextmanager
    def _buried_if_cut_off(self, worker: _Worker) -> Iterator[None]:
        """Where a message is not whole, since the worker died or this process was interrupted, it goes."""
        try:
            yield
        except BaseException as error:
            self._bury(worker)
            if not isinstance(error, EOFError | OSError):
                raise

    def _least_busy(self) -> _Worker:
        """A worker that has nothing, started if there may be more; else one that has least."""
        least = min(self._workers, key=lambda worker: len(worker.has), default=None)
        if least is None or (least.has and len(self._workers) < self._number):
            least = self._started()
            self._workers.append(least)
        return least

    def _started(self) -> _Worker:
        """A new process, which shares nothing with threads of this one."""
        methods = multiprocessing.get_all_start_methods()
        context: Any = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
        context.set_forkserver_preload(["eai.results.batch"])  # imported once, not in every process
        if "forkserver" in methods:
            resource_tracker.ensure_running()  # which lets interrupts in when it starts
            with _interrupts_held():  # until what starts all workers is there, who inherit that
                ensure_running()
        if self._folder is None:
            self._folder = TemporaryDirectory(prefix="eai-workers-", ignore_cleanup_errors=True)
        connection, theirs = context.Pipe()
        with theirs:
            process = context.Process(target=serve, args=(theirs, self._folder.name), daemon=True)
            process.start()
        return _Worker(process, connection)

    def _bury(self, worker: _Worker) -> None:
        """Take away a worker that died; what it had is done again, and by nobody what has killed too many."""
        self._workers.remove(worker)
        worker.connection.close()
        worker.process.kill()
        worker.process.join()
        if not worker.has:
            return
        at = worker.has[0]
        at.deaths += 1
        if at.deaths == MAX_DEATHS:
            at.result = pickle.dumps(EaiError(_named_items(at.items)))
            worker.has.popleft()
        self._waiting.extendleft(reversed(worker.has))


def _remove(folder: TemporaryDirectory[str]) -> None:
    """Remove a folder in which a planner may write until it notices that its worker was killed."""
    end = time.monotonic() + CLEANING_SECONDS
    folder.cleanup()
    while Path(folder.name).exists() and time.monotonic() < end:
        time.sleep(PAUSE_SECONDS)
        folder.cleanup()


def split_batches(items: Iterable[T], workers: int, size: int, largest: int) -> Iterator[Sequence[T]]:
    """The items in batches that grow until they are large enough."""
    source, made = iter(items), 0
    while batch := list(islice(source, size)):
        yield batch
        made += 1
        if made % workers == 0:
            size = min(2 * size, largest)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Interrupts wait until the end of the block, and so they do for ever in processes that it starts."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _named_items(items: Sequence[Any]) -> str:
    hint = "is there enough memory, and does the program begin below `if __name__ == '__main__':`?"
    first = str(items[0])[:100]
    return f"workers died {MAX_DEATHS} times at the same {len(items)} items from {first!r} on; {hint}"
