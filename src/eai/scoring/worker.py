"""The loop of a worker: batches come through a pipe, results leave through it, and without it it ends."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from functools import lru_cache
from multiprocessing.connection import Connection
from multiprocessing.pool import ExceptionWithTraceback  # type: ignore[attr-defined] # not in its stub
from queue import SimpleQueue
from types import FrameType
from typing import Any, NamedTuple

from eai.errors import WorkerError
from eai.scoring.collector import collect_seldom

ENDED = 128 + signal.SIGTERM
"""The exit status of a worker that is ended, as a shell has it."""

CLEANING_SECONDS = 1
"""How long a worker may take to end its planners and to remove their files before it is killed."""


class Given(NamedTuple):
    """The input of a worker: some pickled work, which it keeps, and what to do it on."""

    work: bytes
    items: Sequence[Any]


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
        given: Given = pickle.loads(content)  # noqa: S301 - of a process of this program
        return pickle.dumps(loaded(given.work)(given.items))
    except Exception as error:
        return _error_bytes(error)


def _error_bytes(error: Exception) -> bytes:
    """An exception with its traceback, to be raised elsewhere; in words if it cannot be sent."""
    try:
        content = pickle.dumps(ExceptionWithTraceback(error, error.__traceback__))
        pickle.loads(content)  # noqa: S301 - some can be pickled and not loaded
    except Exception:
        return pickle.dumps(WorkerError(f"{type(error).__name__}: {error}"))
    return content


@lru_cache(maxsize=8)
def loaded(work: bytes) -> Callable[[Sequence[Any]], Sequence[Any]]:
    """Work as it was pickled; opening the tasks that it is about takes long."""
    known: Callable[[Sequence[Any]], Sequence[Any]] = pickle.loads(work)  # noqa: S301 - of this program
    return known
