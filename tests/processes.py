"""The command line in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import NamedTuple


class Outcome(NamedTuple):
    """What a command left: its exit status and what it printed."""

    status: int
    out: str
    err: str


def eai(*arguments: object, **environment: str) -> Outcome:
    """Run `eai` in a process of its own, since Inspect's warnings are none of ours."""
    command = [sys.executable, "-c", "from eai.cli import main; main()", *map(str, arguments)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env={**os.environ, "COLUMNS": "120", **environment},
    )
    return Outcome(done.returncode, done.stdout, done.stderr)
