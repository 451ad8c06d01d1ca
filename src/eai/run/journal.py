"""The journal of a run: every answer as it arrived, one line each, before anything is made of it.

It is what a run is resumed from: a line is whole or, after a crash in the middle of writing it, ignored.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedWriter
from pathlib import Path

from filelock import FileLock, Timeout
from pydantic import TypeAdapter, ValidationError

from eai.errors import InputError
from eai.scoring.answer import Answer, Place

JOURNAL = "answers.jsonl"
"""Name of the journal in the folder of a run."""

LOCK = "answers.lock"
"""Name of the file beside it that a process holds which works there."""


class Journal:
    """The answers of one run in a file that is only ever appended to.

    It is to be closed, as a context manager or by `close`.

    Args:
        path: the file; it and its folder come into being with the first answer.

    Raises:
        InputError: the file cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BufferedWriter | None = None
        self._answers: dict[str, dict[tuple[str, int, int], Answer]] = {}
        for answer in _read(path):
            self._keep(answer)

    def find(self, place: Place, request_sha256: str, attempt: int = 1) -> Answer | None:
        """The answer to this very request, or None."""
        return self._answers.get(request_sha256, {}).get((*place, attempt))

    def add(self, answer: Answer) -> None:
        """Write an answer down; when this returns, the end of the process cannot lose it.

        Raises:
            InputError: the file cannot be written, or is not there any more.
        """
        try:
            if self._file is None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self._path.open("ab")
            self._file.write(json.dumps(answer.to_json()).encode() + b"\n")
            self._file.flush()
            self._path.stat()
        except OSError as error:
            raise self._unwritten(error) from error
        self._keep(answer)

    def close(self) -> None:
        """Close the file; another answer would open it again.

        Raises:
            InputError: what could not be written before still cannot.
        """
        file, self._file = self._file, None
        try:
            if file is not None:
                file.close()
        except OSError as error:
            raise self._unwritten(error) from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _unwritten(self, error: OSError) -> InputError:
        return InputError(f"{self._path}: cannot be written ({error.strerror})")

    def _keep(self, answer: Answer) -> None:
        place = (answer.task_id, answer.epoch, answer.attempt)
        self._answers.setdefault(answer.request_sha256, {})[place] = answer


@contextmanager
def sole_run(folder: Path) -> Iterator[None]:
    """Keeps other processes out of the folder of a run during the block; the folder is made if need be.

    Raises:
        InputError: another process is working there, or the folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = FileLock(folder / LOCK, timeout=0)
        lock.acquire()
    except Timeout as error:
        hint = "wait for its end, or give another --out"
        raise InputError(f"{folder}: another process is running there; {hint}") from error
    except NotImplementedError:  # a file system without locks
        yield
        return
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror})") from error
    try:
        yield
    finally:
        lock.release()


def _read(path: Path) -> Iterator[Answer]:
    """The whole lines of a file; what an interrupted writer left at its end is cut off."""
    if not path.exists():
        return
    adapter = TypeAdapter(Answer)
    try:
        content = path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            with path.open("r+b") as file:
                file.truncate(whole)
        for number, line in enumerate(content[:whole].splitlines(), 1):
            try:
                yield adapter.validate_json(line)
            except ValidationError as error:
                raise InputError(f"{path}, line {number}: expected an answer of a run") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
