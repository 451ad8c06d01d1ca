"""Run the command line in a separate process, and find processes that work in a folder."""

from __future__ import annotations

import atexit
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext, ForkServerProcess
from multiprocessing.forkserver import ForkServer
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

from eai.cli import main
from eai.results.collector import reduce_garbage_collection

_SECONDS = 600
"""Maximum seconds of a command."""


class Outcome(NamedTuple):
    """Exit status and output of a command."""

    status: int
    out: str
    err: str


_SERVER = ForkServer()
_SERVER.set_forkserver_preload(
    [
        "eai.cli.run",
        "eai.run.tasks",
        "eai.run.registry",
        "eai.benchmarks.behavior.benchmark",
        "eai.benchmarks.virtualhome.benchmark",
        "inspect_ai.agent._acp.server",
        "inspect_ai.hooks._startup",
        "inspect_ai.model._openai_responses",
        "uvicorn",
    ]
)
"""Forks processes that have imported what runs need; the last four are what Inspect imports when it begins.

It is not the server of the whole process, which workers that score may have started without Inspect.
"""


class _Forked(ForkServerProcess):
    """A process that the fork server forks."""

    @staticmethod
    def _Popen(process_obj: BaseProcess) -> Any:  # noqa: N802 - of multiprocessing
        with patch.object(forkserver, "connect_to_new_process", _SERVER.connect_to_new_process):
            return ForkServerProcess._Popen(process_obj)  # type: ignore[attr-defined]


class _Context(ForkServerContext):
    Process = _Forked


@contextmanager
def own_process() -> Iterator[Executor]:
    """Yield an executor with a separate process for Inspect, whose warnings would fail our tests.

    Functions are sent to it by name.
    """
    with ProcessPoolExecutor(1, _Context()) as pool:
        yield pool


class Command:
    """`eai` in a separate process, forked from one that has imported Inspect, because this import is slow.

    Args:
        arguments: Arguments of the command.
        before: Function that the process calls first, sent by name.
        columns: Width of its terminal.
    """

    def __init__(
        self, *arguments: object, before: Callable[[], None] | None = None, columns: int = 120
    ) -> None:
        self._printed = tempfile.TemporaryDirectory()
        started = {**os.environ, "COLUMNS": str(columns)}
        words = list(map(str, arguments))
        self._process = _Forked(target=_run, args=(words, started, str(Path.cwd()), self._files, before))
        self._process.start()

    @property
    def _files(self) -> tuple[Path, Path]:
        """Files of the command's output and messages."""
        return Path(self._printed.name, "out"), Path(self._printed.name, "err")

    def signal(self, number: signal.Signals) -> None:
        assert self._process.pid is not None
        os.kill(self._process.pid, number)

    @property
    def out(self) -> str:
        """Output of the command so far."""
        return self._files[0].read_text() if self._files[0].exists() else ""

    def end(self) -> None:
        """Kill the command if it has not ended yet."""
        self._process.kill()

    def outcome(self) -> Outcome:
        """Return the outcome after the command has ended. The status is negative if a signal ended it."""
        self._process.join(_SECONDS)
        status = self._process.exitcode
        if status is None:
            self.end()
            raise TimeoutError
        with self._printed:
            return Outcome(status, *(each.read_text() for each in self._files))


def eai(*arguments: object, columns: int = 120, **environment: str) -> Outcome:
    """Run `eai` in a separate process, because Inspect's warnings would fail our tests.

    With environment variables, a new interpreter is started, because a library may read them on import.
    """
    if not environment:
        return Command(*arguments, columns=columns).outcome()
    command = [sys.executable, "-c", "from eai.cli import main; main()", *map(str, arguments)]
    started = {**os.environ, "COLUMNS": str(columns), **environment}
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=_SECONDS, env=started)
    return Outcome(done.returncode, done.stdout, done.stderr)


def _run(
    arguments: list[str],
    environment: dict[str, str],
    folder: str,
    printed: tuple[Path, Path],
    before: Callable[[], None] | None,
) -> None:
    """Run a command in a forked process."""
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.path.insert(0, "")
    for descriptor, (name, path) in enumerate(zip(("stdout", "stderr"), printed, strict=True), 1):
        with path.open("wb") as file:
            os.dup2(file.fileno(), descriptor)
        setattr(sys, name, open(descriptor, "w", closefd=False))  # noqa: SIM115 - of a descriptor
    sys.argv = ["eai", *arguments]
    reduce_garbage_collection()  # as `eai.__main__` does
    try:
        if before is not None:
            before()
        main()
    finally:
        atexit._run_exitfuncs()  # a forked process does not do this by itself
        sys.stdout.flush()
        sys.stderr.flush()


def working_in(folder: Path) -> list[str]:
    """Return the processes whose working directory is below a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and str(folder) in str((entry / "cwd").readlink()):
                found.append(entry.name)
        except OSError:
            continue
    return found


def wait_until(condition: Callable[[], object], seconds: float = _SECONDS) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    return bool(condition())
