"""Fast Downward as a planner: the binaries of the wheel ``up-fast-downward``, two processes a call.

Every call works in a private temporary folder, which is removed whatever happens, so any number of calls
may run at once. Both processes (translator and search) run under the operating system's limits of CPU time
and memory, and are killed with everything that they started when the call is interrupted. Processes that plan
together share room for planners through a folder (`planner_slot`).
"""

from __future__ import annotations

import contextlib
import importlib.metadata
import importlib.util
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from filelock import Timeout

from eai.base.errors import DataError, install_command
from eai.base.files import make_lock
from eai.pddl.execute import PlanStep
from eai.pddl.planning import PlannerOutcome, PlannerResult, PlanningTask, check_plan
from eai.pddl.writer import write_domain, write_problem

_MEMORY_MIB = 4096
"""Memory that one planner may use."""

_PAUSE_SECONDS = 0.05
"""Seconds until a slot is looked for again; a call of a planner takes longer."""


@contextmanager
def planner_slot(number: int, folder: Path) -> Iterator[None]:
    """Wait for one of so many slots in all processes that share a folder, and keep it during the block."""
    locks = [make_lock(folder / f"seat-{i}.lock")[1] for i in range(number)]
    while True:
        for lock in locks:
            try:
                lock.acquire(timeout=0)
            except Timeout:
                continue
            try:
                yield
            finally:
                lock.release()
            return
        time.sleep(_PAUSE_SECONDS)


def machine_memory_mib() -> int:
    """The memory that there is: of the machine, or of the control group that this process is confined to."""
    most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limit = Path("/sys/fs/cgroup/memory.max")
    text = limit.read_text().strip() if limit.is_file() else ""
    return (min(most, int(text)) if text.isdigit() else most) >> 20


_DISTRIBUTION = "up-fast-downward"
_MODULE = "up_fast_downward"
_BINARIES = Path("downward", "builds", "release", "bin")
_MISSING = f"Fast Downward is not installed: {install_command('planner')}"
_LAUNCHER = Path(__file__).with_name("limited.py")
_WALL_FACTOR = 4
"""Seconds on the clock that a process may take for each second of CPU time that it is allowed."""

_LAMA_FIRST = (
    "let(landmarks, landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()), pref=false), "
    "let(relaxed_plan, ff(), "
    "lazy_greedy([relaxed_plan, landmarks], preferred=[relaxed_plan, landmarks], "
    "cost_type=one, reopen_closed=false)))"
)
"""The alias ``lama-first`` for problems without action costs."""

_OUTCOMES = {
    **dict.fromkeys((10, 11, 12), PlannerOutcome.UNSOLVABLE),
    **dict.fromkeys((20, 22), PlannerOutcome.MEMORY),
    **dict.fromkeys((21, 23, 24, -signal.SIGXCPU), PlannerOutcome.TIME),
    **dict.fromkeys((31, 33), PlannerOutcome.INPUT_ERROR),
    34: PlannerOutcome.UNSUPPORTED,
}
"""Exit statuses (https://www.fast-downward.org/latest/documentation/exit-codes/); any other is a crash."""


class _ProcessEnd(NamedTuple):
    """How a process ended; ``status`` is None if it exceeded the time on the clock."""

    status: int | None
    output: str


@dataclass(frozen=True, slots=True)
class FastDownward:
    """Fast Downward with the configuration ``lama-first``.

    Attributes:
        binaries: the folder with the program ``downward`` and the package of the translator.
        version: that of the wheel; it belongs into every report, for it decides the numbers.
        cpu_seconds: how long each of the two processes of a call may compute.
        memory_mib: how much memory each of them may use.
        slots: how many calls there may be at a time, and the folder through which processes share them; any
            number if None.
        remark: what its name says besides, where the limits are not the usual ones.
    """

    binaries: Path
    version: str
    cpu_seconds: int
    memory_mib: int
    slots: tuple[int, Path] | None = None
    remark: str = ""

    @classmethod
    def find_installed(cls, cpu_seconds: int = 100) -> FastDownward:
        """The planner of the current environment.

        Raises:
            DataError: it is not installed; the message says how to install it.
        """
        binaries = _find_binaries()
        if binaries is None:
            raise DataError(_MISSING)
        return cls(binaries, importlib.metadata.version(_DISTRIBUTION), cpu_seconds, _MEMORY_MIB)

    @staticmethod
    def is_installed() -> bool:
        """Whether the current environment has it."""
        return _find_binaries() is not None

    @property
    def name(self) -> str:
        """Its name in records."""
        return f"Fast Downward {self.version}{self.remark}"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan."""
        turn = nullcontext() if self.slots is None else planner_slot(*self.slots)
        with turn, tempfile.TemporaryDirectory(prefix="eai-planner-") as folder:
            return self._solve_in(Path(folder), task)

    def _solve_in(self, folder: Path, task: PlanningTask) -> PlannerResult:
        (folder / "domain.pddl").write_text(write_domain(task.domain))
        (folder / "problem.pddl").write_text(write_problem(task.problem))
        translated = self._translate(folder, keep_everything=task.fatal is not None)
        if translated.status != 0:
            return self._failure(translated)
        if task.fatal is not None and _mentions(folder / "output.sas", task.fatal.predicate):
            detail = f"{self.name}: an effect that adds an unbound variable is reachable"
            return PlannerResult(PlannerOutcome.CRASH, detail=detail)
        searched = self._search(folder)
        if searched.status != 0:
            return self._failure(searched)
        return check_plan(task, _read_plan(folder / "plan"), self.name)

    def _translate(self, folder: Path, *, keep_everything: bool) -> _ProcessEnd:
        command = [sys.executable, "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"]
        if keep_everything:
            command.append("--keep-unimportant-variables")
        return self._run(folder, [*command, "--sas-file", "output.sas"], Path(os.devnull))

    def _search(self, folder: Path) -> _ProcessEnd:
        command = [str(self.binaries / "downward"), "--search", _LAMA_FIRST, "--internal-plan-file", "plan"]
        return self._run(folder, command, folder / "output.sas")

    def _run(self, folder: Path, command: list[str], stdin: Path) -> _ProcessEnd:
        """Run one program in the folder, under limits and in a process group of its own."""
        limits = map(str, (os.getpid(), self.cpu_seconds, self.memory_mib << 20))
        with stdin.open() as source, (folder / "log").open("w+") as log:
            process = subprocess.Popen(  # noqa: S603 - a program of ours on files of ours
                [sys.executable, "-I", str(_LAUNCHER), *limits, *command],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": str(self.binaries), "PYTHONHASHSEED": "0"},
                stdin=source,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                status: int | None = process.wait(self.cpu_seconds * _WALL_FACTOR)
            except subprocess.TimeoutExpired:
                status = None
            finally:
                _kill_group(process)
            log.seek(0)
            return _ProcessEnd(status, log.read())

    def _failure(self, ended: _ProcessEnd) -> PlannerResult:
        if ended.status is None:
            return PlannerResult(PlannerOutcome.TIME, detail=f"{self.name}: time on the clock")
        outcome = _OUTCOMES.get(ended.status, PlannerOutcome.CRASH)
        lines = ended.output.strip().splitlines()
        last = lines[-1] if lines else "no output"
        return PlannerResult(outcome, detail=f"{self.name}: exit status {ended.status}: {last}")


def _find_binaries() -> Path | None:
    """The folder of the programs; None if they are not installed."""
    spec = importlib.util.find_spec(_MODULE)
    if spec is None or not spec.submodule_search_locations:
        return None
    binaries = Path(spec.submodule_search_locations[0]) / _BINARIES
    return binaries if (binaries / "downward").is_file() else None


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and everything it started; harmless when they have ended."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _mentions(path: Path, predicate: str) -> bool:
    return f"Atom {predicate}(" in path.read_text()


def _read_plan(path: Path) -> list[PlanStep]:
    """The steps of a plan file: one parenthesised line each, comments behind a semicolon."""
    lines = (line.split(";")[0].strip() for line in path.read_text().splitlines())
    words = [line.strip("()").split() for line in lines if line]
    return [PlanStep(name, tuple(arguments)) for name, *arguments in words]
