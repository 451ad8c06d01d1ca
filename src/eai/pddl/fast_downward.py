"""Run Fast Downward as a planner, from the binaries of the wheel ``up-fast-downward``.

A call runs two processes. Every call works in a private temporary folder, which is always removed, so any
number of calls may run at once. Both processes (translator and search) run under the operating system's
limits of CPU time and memory. They and all their child processes are killed if the call is interrupted.
Processes that share a folder limit the number of planner calls at a time (`hold_permit_to_call_planner`),
and plan once for equal tasks.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from filelock import Timeout

from eai.base.errors import DataError, make_install_command
from eai.base.files import make_file_lock, write_files_atomically
from eai.pddl.execute import PlanStep
from eai.pddl.limited import make_limited_command
from eai.pddl.planning import PlannerOutcome, PlannerResult, PlanningTask, execute_found_plan
from eai.pddl.writer import write_domain, write_problem

_MEMORY_MIB = 4096
"""Memory limit of one planner, in MiB."""

_PAUSE_SECONDS = 0.05
"""Seconds between two attempts to start a planner while too many planners run.

This is shorter than one call of a planner.
"""


@contextmanager
def hold_permit_to_call_planner(max_calls: int, lock_folder: Path) -> Iterator[None]:
    """Hold a permit to call a planner during a ``with`` block. Wait until a permit is free.

    There are ``max_calls`` permits. All processes that use the same folder share them.
    """
    locks = [make_file_lock(lock_folder / f"seat-{i}.lock")[1] for i in range(max_calls)]
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


def measure_machine_memory_mib() -> int:
    """Return the memory in MiB of the machine, or of this process's control group if that is smaller."""
    most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limit = Path("/sys/fs/cgroup/memory.max")
    text = limit.read_text().strip() if limit.is_file() else ""
    return (min(most, int(text)) if text.isdigit() else most) >> 20


_DISTRIBUTION = "up-fast-downward"
_MODULE = "up_fast_downward"
_BINARIES = Path("downward", "builds", "release", "bin")
_MISSING = f"Fast Downward is not installed: {make_install_command('planner')}"
_WALL_FACTOR = 4
"""Seconds of wall-clock time that a process may take for each allowed second of CPU time."""

_LAMA_FIRST = (
    "let(landmarks, landmark_sum(lm_factory=lm_reasonable_orders_hps(lm_rhw()), pref=false), "
    "let(relaxed_plan, ff(), "
    "lazy_greedy([relaxed_plan, landmarks], preferred=[relaxed_plan, landmarks], "
    "cost_type=one, reopen_closed=false)))"
)
"""Search options of Fast Downward's alias ``lama-first`` for problems without action costs."""

_OUTCOMES = {
    **dict.fromkeys((10, 11, 12), PlannerOutcome.UNSOLVABLE),
    **dict.fromkeys((20, 22), PlannerOutcome.MEMORY),
    **dict.fromkeys((21, 23, 24, -signal.SIGXCPU), PlannerOutcome.TIME),
    **dict.fromkeys((31, 33), PlannerOutcome.INPUT_ERROR),
    34: PlannerOutcome.UNSUPPORTED,
}
"""Mapping from exit statuses of Fast Downward to outcomes. Any other status is a crash.

Source: https://www.fast-downward.org/latest/documentation/exit-codes/
"""


class _EndedProcess(NamedTuple):
    """The exit status and output of a process; the status is None if it exceeded its wall-clock time."""

    status: int | None
    output: str


@dataclass(frozen=True, slots=True)
class FastDownward:
    """Fast Downward with the configuration ``lama-first``.

    Attributes:
        binaries: the folder with the program ``downward`` and the package of the translator.
        version: version of the wheel; reports must name the version, because results depend on it.
        cpu_seconds: CPU seconds for each of the two processes of a call.
        memory_mib: memory limit of each process, in MiB.
        slots: maximum number of planner calls at a time, and the folder through which processes share this
            limit and the results of calls; None for no limit.
        remark: text after the planner's name in stored verdicts if limits differ from the default limits.
    """

    binaries: Path
    version: str
    cpu_seconds: int
    memory_mib: int
    slots: tuple[int, Path] | None = None
    remark: str = ""

    @classmethod
    def find_installed(cls, cpu_seconds: int = 100) -> FastDownward:
        """Return the planner installed in the current Python environment.

        Raises:
            DataError: the planner is not installed. The message has the install command.
        """
        binaries = _find_binaries()
        if binaries is None:
            raise DataError(_MISSING)
        return cls(binaries, importlib.metadata.version(_DISTRIBUTION), cpu_seconds, _MEMORY_MIB)

    @staticmethod
    def is_installed() -> bool:
        """Whether the current environment has the planner."""
        return _find_binaries() is not None

    @property
    def name(self) -> str:
        """The name of the planner in stored verdicts (records)."""
        return f"Fast Downward {self.version}{self.remark}"

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Search for a plan.

        Processes that share a folder (`slots`) share their results: each task is searched only once.
        """
        domain, problem = write_domain(task.domain), write_problem(task.problem)
        if self.slots is None:
            return self._find_plan(task, domain, problem)
        max_calls, shared_folder = self.slots
        deciding_values = repr((self.cpu_seconds, self.memory_mib, domain, problem, task.fatal))
        file = shared_folder / f"{hashlib.sha256(deciding_values.encode()).hexdigest()}.pickle"
        shared_folder.mkdir(exist_ok=True)  # on other machines of a cluster, the folder is missing
        with make_file_lock(file.with_suffix(".lock"))[1]:
            if not file.exists():
                with hold_permit_to_call_planner(max_calls, shared_folder):
                    result = self._find_plan(task, domain, problem)
                write_files_atomically({file: pickle.dumps(result)})
            shared_result: PlannerResult = pickle.loads(file.read_bytes())  # noqa: S301 - of a process of this program
            return shared_result

    def _find_plan(self, task: PlanningTask, domain: str, problem: str) -> PlannerResult:
        with tempfile.TemporaryDirectory(prefix="eai-planner-") as folder:
            return self._run_fast_downward_in_folder(Path(folder), task, domain, problem)

    def _run_fast_downward_in_folder(
        self, folder: Path, task: PlanningTask, domain: str, problem: str
    ) -> PlannerResult:
        (folder / "domain.pddl").write_text(domain)
        (folder / "problem.pddl").write_text(problem)
        translated = self._run_translator(folder, keep_everything=task.fatal is not None)
        if translated.status != 0:
            return self._make_failure_result(translated)
        if task.fatal is not None and _mentions_predicate(folder / "output.sas", task.fatal.predicate):
            detail = f"{self.name}: an effect that adds an unbound variable is reachable"
            return PlannerResult(PlannerOutcome.CRASH, detail=detail)
        searched = self._run_search(folder)
        if searched.status != 0:
            return self._make_failure_result(searched)
        return execute_found_plan(task, _read_plan(folder / "plan"), self.name)

    def _run_translator(self, folder: Path, *, keep_everything: bool) -> _EndedProcess:
        command = [sys.executable, "-m", "fast_downward.translate", "domain.pddl", "problem.pddl"]
        if keep_everything:
            command.append("--keep-unimportant-variables")
        return self._run_command(folder, [*command, "--sas-file", "output.sas"], Path(os.devnull))

    def _run_search(self, folder: Path) -> _EndedProcess:
        command = [str(self.binaries / "downward"), "--search", _LAMA_FIRST, "--internal-plan-file", "plan"]
        return self._run_command(folder, command, folder / "output.sas")

    def _run_command(self, folder: Path, command: list[str], stdin: Path) -> _EndedProcess:
        """Run one program in the folder, under limits and in its own process group."""
        with stdin.open() as source, (folder / "log").open("w+") as log:
            process = subprocess.Popen(  # noqa: S603 - a program of ours on files of ours
                make_limited_command(command, self.cpu_seconds, self.memory_mib << 20),
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
            return _EndedProcess(status, log.read())

    def _make_failure_result(self, ended: _EndedProcess) -> PlannerResult:
        if ended.status is None:
            return PlannerResult(PlannerOutcome.TIME, detail=f"{self.name}: time on the clock")
        outcome = _OUTCOMES.get(ended.status, PlannerOutcome.CRASH)
        lines = ended.output.strip().splitlines()
        last = lines[-1] if lines else "no output"
        return PlannerResult(outcome, detail=f"{self.name}: exit status {ended.status}: {last}")


def _find_binaries() -> Path | None:
    """Return the folder of Fast Downward's programs; None if they are not installed."""
    spec = importlib.util.find_spec(_MODULE)
    if spec is None or not spec.submodule_search_locations:
        return None
    binaries = Path(spec.submodule_search_locations[0]) / _BINARIES
    return binaries if (binaries / "downward").is_file() else None


def _kill_group(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and all its child processes; does nothing if they have ended."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _mentions_predicate(path: Path, predicate: str) -> bool:
    return f"Atom {predicate}(" in path.read_text()


def _read_plan(path: Path) -> list[PlanStep]:
    """Return the steps of a plan file: one parenthesised line each, comments after a semicolon."""
    lines = (line.split(";")[0].strip() for line in path.read_text().splitlines())
    words = [line.strip("()").split() for line in lines if line]
    return [PlanStep(name, tuple(arguments)) for name, *arguments in words]
