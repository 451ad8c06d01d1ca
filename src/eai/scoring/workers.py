"""Work spread over processes that stay: results in order, and a process that dies costs nothing but time."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from multiprocessing.forkserver import ensure_running
from types import FrameType, TracebackType
from typing import Any, TypeVar

from typing_extensions import Self

from eai.errors import WorkerError
from eai.scoring.undisturbed import disturb_seldom

T = TypeVar("T")
R = TypeVar("R")

CLEANING_SECONDS = 1
"""How long interrupted workers may take, all together, to end their planners and to remove their files."""

SMALLEST, LARGEST = 16, 1024
"""How many items a worker is given at a time: few at first, so that all have some, then more."""

AHEAD = 3
"""For how many batches a worker there may be at a time, those included whose results are not yet taken."""

DEATHS = 3
"""How often workers may die before a result comes."""


@dataclass(frozen=True, slots=True)
class _Batch:
    """Some items of a stream, and what becomes of them."""

    items: Sequence[Any]
    results: Future[bytes]


class Workers:
    """Processes that do work on streams of items, and stay until they are closed.

    Results come in the order of the items. No more than a few batches are read ahead, so that memory does not
    grow with the stream. What a worker that dies was at is done again: nothing is lost, nothing comes twice.

    Args:
        workers: how many processes to use; this one alone if fewer than two.
    """

    def __init__(self, workers: int = 1) -> None:
        self._number = workers
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close(at_once=kind is not None)

    def close(self, *, at_once: bool = False) -> None:
        """End the workers: when they have done what they are at, or at once, whatever they do.

        A terminal interrupts all processes at once. A worker that ended by itself might hold a lock for which
        another would wait for ever, so that workers leave it to this process, which has them clean up and
        kills what stays.
        """
        pool, self._pool = self._pool, None
        if pool is None:
            return
        if at_once:
            processes = list((getattr(pool, "_processes", None) or {}).values())
            for process in processes:
                process.terminate()
            end = time.monotonic() + CLEANING_SECONDS
            for process in processes:
                process.join(max(0, end - time.monotonic()))
                process.kill()
        pool.shutdown(cancel_futures=True)

    def each(
        self,
        work: Callable[..., Sequence[R]],
        items: Iterable[T],
        *,
        at_a_time: tuple[int, int] = (SMALLEST, LARGEST),
    ) -> Iterator[R]:
        """What a function makes of the items, in their order.

        Args:
            work: from a batch of items to as many results. It is pickled; each worker loads it once, as long
                as it is one of the last few.
            items: the items; pickled, as are results.
            at_a_time: how many items a worker is given at first, and at most.

        Raises:
            WorkerError: workers die whenever they come to certain items.
        """
        if self._number < 2:
            for item in items:
                yield from work((item,))
            return
        content = pickle.dumps(work)
        ahead: deque[_Batch] = deque()
        coming = _batches(items, self._number, *at_a_time)
        deaths = 0
        while True:
            for batch in islice(coming, self._number * AHEAD - len(ahead)):
                ahead.append(_Batch(batch, self._submit(content, batch)))
            if not ahead:
                return
            try:
                results = _unpacked(ahead[0].results.result())
            except BrokenProcessPool as error:
                deaths += 1
                if deaths == DEATHS:
                    raise WorkerError(_told(ahead[0].items)) from error
                self._revive()
                ahead = deque([self._again(content, batch) for batch in ahead])
                continue
            deaths = 0
            ahead.popleft()
            yield from results

    def _submit(self, content: bytes, batch: Sequence[Any]) -> Future[bytes]:
        items = pickle.dumps(batch)  # plainly: as a pool does it takes twice as long
        try:
            return self._opened().submit(_done, content, items)
        except BrokenProcessPool:  # a worker died while none of them had anything to do
            self._revive()
            return self._opened().submit(_done, content, items)

    def _again(self, content: bytes, batch: _Batch) -> _Batch:
        """A batch that was done before the workers ended, or else the same to be done anew."""
        done = batch.results.done() and not batch.results.cancelled() and batch.results.exception() is None
        return batch if done else _Batch(batch.items, self._submit(content, batch.items))

    def _opened(self) -> ProcessPoolExecutor:
        """The processes, started when they are first needed; they share nothing with threads of this one."""
        if self._pool is None:
            methods = multiprocessing.get_all_start_methods()
            context = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
            context.set_forkserver_preload(["eai.scoring.batch"])  # imported once, not in every process
            with _interrupts_held():  # until what starts all workers is there, who inherit that
                if "forkserver" in methods:
                    ensure_running()
            self._pool = ProcessPoolExecutor(self._number, context, initializer=_begin)
        return self._pool

    def _revive(self) -> None:
        """Other processes in the place of those of which one died."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(cancel_futures=True)


def _batches(items: Iterable[T], workers: int, size: int, largest: int) -> Iterator[Sequence[T]]:
    """The items in batches that grow until they are large enough."""
    source, made = iter(items), 0
    while batch := list(islice(source, size)):
        yield batch
        made += 1
        if made % workers == 0:
            size = min(2 * size, largest)


def _done(content: bytes, items: bytes) -> bytes:
    """In a worker: what some work makes of a batch; told to end, it does so when it has cleaned up."""
    try:
        signal.signal(signal.SIGTERM, _end)
        try:
            return pickle.dumps(_loaded(content)(_unpacked(items)))
        finally:
            signal.signal(signal.SIGTERM, _leave)
    except SystemExit:
        os._exit(128 + signal.SIGTERM)


@lru_cache(maxsize=8)
def _loaded(content: bytes) -> Callable[..., Sequence[Any]]:
    """In a worker: the work; opening the tasks that it is about takes long."""
    work: Callable[..., Sequence[Any]] = _unpacked(content)
    return work


def _unpacked(content: bytes) -> Any:
    return pickle.loads(content)  # noqa: S301 - of a process of this program


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


def _begin() -> None:
    """In a worker: leave interrupts to who started it, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    disturb_seldom()


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once, with nothing to clean up: a pool would catch an exception, and send it as a result.

    It would wait for ever where another worker was killed while it sent one.
    """
    os._exit(128 + number)


def _end(number: int, frame: FrameType | None) -> None:
    """End as an exception does, so that planners are ended and their folders removed."""
    sys.exit(128 + number)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(CLEANING_SECONDS)
        os._exit(128 + signal.SIGTERM)


def _told(items: Sequence[Any]) -> str:
    hint = "is there enough memory, and does the program begin below `if __name__ == '__main__':`?"
    return (
        f"workers died {DEATHS} times at the same {len(items)} items from {str(items[0])[:100]!r} on; {hint}"
    )
