"""The command line in a process of its own, and the processes that work in a folder."""

from __future__ import annotations

import atexit
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from multiprocessing import get_all_start_methods, get_context
from pathlib import Path
from typing import NamedTuple

from eai.cli import main

_SECONDS = 600
"""How long a command may take, on the clock."""


class Outcome(NamedTuple):
    """What a command left: its exit status and what it printed."""

    status: int
    out: str
    err: str


def eai(*arguments: object, **environment: str) -> Outcome:
    """Run `eai` in a process of its own, since Inspect's warnings are none of ours.

    It is forked from one that has imported Inspect, which takes longer than most commands do; where variables
    of the environment are given, which a library may read when it is imported, it is started from nothing.
    """
    words = list(map(str, arguments))
    started = {**os.environ, "COLUMNS": "120", **environment}
    if environment or "forkserver" not in get_all_start_methods():
        command = [sys.executable, "-c", "from eai.cli import main; main()", *words]
        done = subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=_SECONDS, env=started
        )
        return Outcome(done.returncode, done.stdout, done.stderr)
    context = get_context("forkserver")
    context.set_forkserver_preload(["eai.cli.run", "eai.run.evaluation", "eai.run.registry"])
    with tempfile.TemporaryDirectory() as folder:
        printed = Path(folder, "out"), Path(folder, "err")
        process = context.Process(target=_run, args=(words, started, str(Path.cwd()), printed))
        process.start()
        process.join(_SECONDS)
        if process.exitcode is None:
            process.kill()
            raise TimeoutError(words)
        return Outcome(process.exitcode, *(each.read_text() for each in printed))


def _run(arguments: list[str], environment: dict[str, str], folder: str, printed: tuple[Path, Path]) -> None:
    """The command in a process that was forked for it."""
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.path.insert(0, "")
    for descriptor, (name, path) in enumerate(zip(("stdout", "stderr"), printed, strict=True), 1):
        with path.open("wb") as file:
            os.dup2(file.fileno(), descriptor)
        setattr(sys, name, open(descriptor, "w", closefd=False))  # noqa: SIM115 - of a descriptor
    sys.argv = ["eai", *arguments]
    try:
        main()
    finally:
        atexit._run_exitfuncs()  # which a process that was forked leaves out
        sys.stdout.flush()
        sys.stderr.flush()


def working_in(folder: Path) -> list[str]:
    """The processes whose working directory is below a folder."""
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
