"""Planning together: what came of a problem, and room for planners, shared by processes through a folder."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock, Timeout

from eai.pddl.execute import PlanStep
from eai.pddl.planning import PddlPlanner, PlannerOutcome, PlannerResult, PlanningTask
from eai.pddl.writer import write_domain, write_problem

_PAUSE = 0.05
"""Seconds until a seat is looked for again; a call of a planner takes longer."""


@dataclass(frozen=True, slots=True)
class SharedPlanner:
    """Asks a planner about each problem once, whichever process asks.

    Two problems are the same if their texts are: those of answers that repeat each other. (Different
    models seldom do: of 338 problems of five models no two were the same.) What two processes come to at
    once may be planned with twice.

    Args:
        planner: who is asked.
        folder: where what came of the problems is kept.
    """

    planner: PddlPlanner
    folder: Path

    @property
    def name(self) -> str:
        """That of the planner."""
        return self.planner.name

    def solve(self, task: PlanningTask) -> PlannerResult:
        """Look for a plan, or look up what was found."""
        path = self.folder / f"{_digest(self.planner.name, task)}.json"
        if path.exists():
            return _from_json(path.read_text(encoding="utf-8"))
        result = self.planner.solve(task)
        with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=self.folder, delete=False) as file:
            file.write(_to_json(result))
        Path(file.name).replace(path)
        return result


def _digest(planner: str, task: PlanningTask) -> str:
    asked = (planner, write_domain(task.domain), write_problem(task.problem), str(task.fatal))
    return hashlib.sha256(json.dumps(asked).encode()).hexdigest()


def _to_json(result: PlannerResult) -> str:
    plan = [[step.action, *step.arguments] for step in result.plan]
    return json.dumps([result.outcome.value, plan, result.detail])


def _from_json(text: str) -> PlannerResult:
    outcome, plan, detail = json.loads(text)
    steps = tuple([PlanStep(name, tuple(arguments)) for name, *arguments in plan])
    return PlannerResult(PlannerOutcome(outcome), steps, detail)


@dataclass(frozen=True, slots=True)
class Seats:
    """So many planners at a time, in all processes that share a folder; who ends gives its seat back.

    Attributes:
        number: how many.
        folder: the folder.
    """

    number: int
    folder: Path

    @contextmanager
    def taken(self) -> Iterator[None]:
        """Wait for a seat, and keep it during the block."""
        locks = [FileLock(self.folder / f"seat-{i}.lock", timeout=0) for i in range(self.number)]
        while True:
            for lock in locks:
                try:
                    lock.acquire()
                except Timeout:
                    continue
                try:
                    yield
                finally:
                    lock.release()
                return
            time.sleep(_PAUSE)


def machine_memory_mib() -> int:
    """The memory that there is: of the machine, or of the control group that this process is confined to."""
    most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    limit = Path("/sys/fs/cgroup/memory.max")
    text = limit.read_text().strip() if limit.is_file() else ""
    return (min(most, int(text)) if text.isdigit() else most) >> 20
