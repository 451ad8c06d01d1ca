"""Replace Fast Downward by a program that only counts calls, also in processes that a test starts."""

from __future__ import annotations

from pathlib import Path

import pytest

from eai.pddl.fast_downward import FastDownward

_TRANSLATOR = """
import sys, time
from pathlib import Path
calls, waiting, limit = map(Path, {paths!r})
with calls.open("a") as file:
    file.write("called\\n")
if limit.exists() and len(calls.read_text().splitlines()) > int(limit.read_text()):
    waiting.touch()
    time.sleep(3600)
sys.exit(11)
"""
"""Source of the program: it finds every task unsolvable. Calls after a limited number do not return."""


class CountedPlanner:
    """A folder with the program and a file with a line for each call.

    Attributes:
        folder: The folder, first on the module path of this process and its workers.
    """

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        if not FastDownward.is_installed():
            pytest.skip("Fast Downward is not installed, so it has no version")
        self.folder = folder
        self._calls, self._waiting, self._limit = (folder / name for name in ("calls", "waiting", "limit"))
        binaries = folder / "up_fast_downward" / "downward" / "builds" / "release" / "bin"
        translator = binaries / "fast_downward"
        translator.mkdir(parents=True)
        for file in (folder / "up_fast_downward" / "__init__.py", binaries / "downward"):
            file.touch()
        (translator / "translate.py").write_text(
            _TRANSLATOR.format(paths=[*map(str, (self._calls, self._waiting, self._limit))])
        )
        monkeypatch.syspath_prepend(folder)

    def limit_calls(self, number: int | None) -> None:
        """Let calls after a number of calls wait; None ends the limit. The calls so far are forgotten."""
        for file in (self._calls, self._waiting, self._limit):
            file.unlink(missing_ok=True)
        if number is not None:
            self._limit.write_text(str(number))

    @property
    def is_waiting(self) -> bool:
        """Whether a call waits."""
        return self._waiting.exists()

    @property
    def calls(self) -> int:
        """Number of calls."""
        return len(self._calls.read_text().splitlines()) if self._calls.exists() else 0
