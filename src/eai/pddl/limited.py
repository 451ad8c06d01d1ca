"""Script that replaces itself by another program with limits. The program dies with the parent process.

    python limited.py PARENT CPU_SECONDS MEMORY_BYTES PROGRAM ARGUMENT...

The limits are the operating system's, so the program cannot evade them. On Linux the system also kills the
program when the parent dies for any reason. PARENT is the process id of the parent. If the parent has died
before the program starts, the script ends. The script uses only the standard library, because it starts
without the package on its path.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
from collections.abc import Sequence

if sys.platform != "win32":
    import resource

_GRACE = 5
"""Seconds of CPU time between the signal that a program can handle and the signal that kills the program."""
_SET_PARENT_DEATH_SIGNAL = 1
"""Option of ``prctl(2)`` that sets the signal at the parent's death: ``PR_SET_PDEATHSIG``."""


def make_limited_command(command: Sequence[str], cpu_seconds: int, memory_bytes: int) -> list[str]:
    """Return the command that runs another command under limits, as a child of this process."""
    limits = map(str, (os.getpid(), cpu_seconds, memory_bytes))
    return [sys.executable, "-I", __file__, *limits, *command]


def exec_limited(parent: int, cpu_seconds: int, memory_bytes: int, command: list[str]) -> None:
    """Replace this process by a command, under limits; end instead if the parent has ended."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_seconds, cpu_seconds + _GRACE))
    with contextlib.suppress(ValueError, OSError):  # macOS cannot limit the address space
        resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != parent:
        sys.exit(128 + signal.SIGKILL)
    os.execv(command[0], command)  # noqa: S606 - replacing the process is the point


if __name__ == "__main__":
    exec_limited(int(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), sys.argv[4:])
