"""Task files: tasks in the world of a benchmark, as JSON lines that people or `eai generate` wrote."""

from __future__ import annotations

import gzip
import hashlib
import json
import re
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

from eai.base.errors import InputError, prefix_errors_with_location
from eai.base.files import number_lines, read_content, write_files_atomically
from eai.base.grouping import MapItems, map_one_by_one
from eai.logic.ltl_printer import print_ltl
from eai.logic.start import is_refuted_by_initial_state
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import is_impossible
from eai.tasks.source import DataMistake, TaskSet
from eai.tasks.special import ImpossibleTaskMark
from eai.tasks.task import Task
from eai.tasks.task_lines import make_task_from_line, read_task_line
from eai.world.domain import Domain
from eai.world.execution import Trajectory, describe_fault, execute_plan, to_trace

ENDINGS = (".jsonl", ".jsonl.gz")
"""The endings of the names of task files."""

_LEADING_ID = re.compile(rb'\{"id": ?"([^"\\]+)"')
"""Pattern of a line that begins with the id of its task. For such a line, only the id must be parsed."""


@dataclass(frozen=True, slots=True)
class _TaskFileLine:
    """A line of a task file: its file, its number and its content."""

    file: Path
    line: int
    content: bytes

    def __str__(self) -> str:
        return f"{self.file}: line {self.line}"


@dataclass(frozen=True)
class _TaskFiles:
    """The tasks of some task files. The line of a task is parsed when the task is first used.

    Attributes:
        name: name of the file or folder, without ending.
        base: name of the benchmark of all tasks, for `find_benchmark`.
        lines: mapping from the id of each task to its line, in the order of the files.
        sha256: SHA-256 digest of the content of all files.
    """

    name: str
    base: str
    lines: Mapping[str, _TaskFileLine]
    sha256: str

    def open_tasks(self, domain: Domain) -> TaskSet[Task]:
        """Return the tasks in the files.

        `domain` is the declaration of the tasks' benchmark.
        """
        return TaskSet(self.lines, lambda task_id: self._make_task(self.lines[task_id], domain), self.sha256)

    def _make_task(self, place: _TaskFileLine, domain: Domain) -> Task:
        with prefix_errors_with_location(place):
            line = read_task_line(place.content)
            if line.base != self.base:
                raise InputError(f"base: expected {self.base!r}, as in the first line, found {line.base!r}")
            return make_task_from_line(line, domain)


def open_task_files(path: Path) -> _TaskFiles:
    """Return the tasks of a file, or of all task files in a folder.

    Raises:
        InputError: there is no file or no task, a task's id is missing or repeated, or the first line is
            wrong. The message names file and line.
    """
    files = find_task_files(path)
    contents = [_read_content(file) for file in files]
    lines: dict[str, _TaskFileLine] = {}
    for file, content in zip(files, contents, strict=True):
        for place in _read_lines(file, content):
            task_id = _read_task_id(place)
            if task_id in lines:
                raise InputError(f"{place}: the id {task_id!r} is already used at {lines[task_id]}")
            lines[task_id] = place
    if not lines:
        raise InputError(f"{path}: expected at least one task")
    first = next(iter(lines.values()))
    with prefix_errors_with_location(first):
        base = read_task_line(first.content).base
    digest = hashlib.sha256(b"\0".join(contents)).hexdigest()
    return _TaskFiles(path.resolve().name.partition(".")[0], base, lines, digest)


def make_task_file_content(lines: Iterable[str]) -> bytes:
    """Return the content of a task file, decompressed if necessary."""
    return "".join(f"{line}\n" for line in lines).encode()


def write_task_file(file: Path, lines: Iterable[str]) -> None:
    """Write a task file, compressed if its name ends in ``.gz``.

    Raises:
        InputError: the name has no ending of a task file, or the file cannot be written.
    """
    if not file.name.endswith(ENDINGS):
        raise InputError(f"{file}: expected a name that ends in {' or '.join(ENDINGS)}")
    content = make_task_file_content(lines)
    write_files_atomically({file: gzip.compress(content, mtime=0) if file.suffix == ".gz" else content})


class _CheckedLine(NamedTuple):
    """The id of the task in a line, None if the line is not a task, and the mistakes in the line."""

    task_id: str | None
    problems: list[str]


def check_task_files(
    path: Path, domain_of: Callable[[str], Domain], map_items: MapItems = map_one_by_one
) -> Iterator[DataMistake]:
    """Yield all mistakes in task files: lines that are not tasks, and tasks with false statements.

    Args:
        path: a file or a folder.
        domain_of: returns the declaration of a benchmark, given the benchmark's name in a line.
        map_items: applies a function to the lines, for example in several processes.

    Raises:
        InputError: the files cannot be opened (`open_task_files`).
    """
    seen: dict[str, _TaskFileLine] = {}
    places = list(read_task_file_lines(path))
    if not places:
        yield DataMistake(str(path), "expected at least one task")
    for place, (task_id, problems) in zip(
        places, map_items(partial(_check_lines, domain_of), places), strict=True
    ):
        if task_id in seen:
            yield DataMistake(str(place), f"the id {task_id!r} is already used at {seen[task_id]}")
            continue
        if task_id is not None:
            seen[task_id] = place
        yield from (DataMistake(str(place), problem) for problem in problems)


def _check_lines(domain_of: Callable[[str], Domain], places: Sequence[_TaskFileLine]) -> list[_CheckedLine]:
    return [_check_line(domain_of, place) for place in places]


def _check_line(domain_of: Callable[[str], Domain], place: _TaskFileLine) -> _CheckedLine:
    task_id = None
    try:
        line = read_task_line(place.content)
        task_id = line.id
        domain = domain_of(line.base)
        return _CheckedLine(task_id, list(find_mistakes_in_task(make_task_from_line(line, domain), domain)))
    except InputError as error:
        return _CheckedLine(task_id, [str(error)])


def find_mistakes_in_task(task: Task, domain: Domain) -> Iterator[str]:
    """Yield a message on each mistake in a task, such as a goal that holds at the start."""
    test = GoalTest(task)
    if all(test.find_reached_goals(task.initial, ())):
        yield "goals: expected a goal that does not hold at the start"
    yield from _find_false_claims_of_solvability(task, domain)
    if not task.has_no_plan:
        yield from _find_broken_goals(task)
    if not task.script:
        return
    trajectory = execute_plan(domain, task.initial, task.script)
    for number, step in enumerate(trajectory.steps):
        if step.fault is not None:
            why = describe_fault(step.fault, domain, step.action, task.scene)
            what = f"{step.fault.kind.value}, {why}"
            yield f"plan.{number}: expected a step that is possible and needed: {what}"
    if trajectory.failure is None:
        operators = [action.operator for action in trajectory.executed_actions]
        reached = test.find_reached_goals(trajectory.final_state, operators, trajectory)
        yield from (
            f"plan: expected to reach goals.{number}" for number, is_met in enumerate(reached) if not is_met
        )


def _find_broken_goals(task: Task) -> Iterator[str]:
    """Yield a message for each goal over time that the initial state already breaks."""
    start = to_trace(Trajectory((task.initial,), ()))
    for number, goal in enumerate(task.goals):
        if goal.is_over_time and is_refuted_by_initial_state(goal.formula, start):
            yield f"goals.{number}: no plan reaches it: the start already breaks {print_ltl(goal.formula)}"


def _find_false_claims_of_solvability(task: Task, domain: Domain) -> Iterator[str]:
    """Yield a message if the task has a plan but is declared impossible, or the other way round."""
    if task.has_no_plan and task.script:
        yield "plan: expected none, as the goals are out of reach for want of a fact"
    elif task.has_no_plan and not is_impossible(task, domain):
        yield "missing: expected goals that are proved to be out of reach, found none"
    elif task.special == ImpossibleTaskMark(()) and not task.script:
        yield "missing: expected a plan, as nothing is missing"


def read_task_file_lines(path: Path) -> Iterator[_TaskFileLine]:
    """Yield the lines of a task file; or of all task files in a folder, sorted by file name.

    Raises:
        InputError: a file cannot be read.
    """
    return (place for file in find_task_files(path) for place in _read_lines(file, _read_content(file)))


def find_task_files(path: Path) -> list[Path]:
    """Return the task files in a folder, sorted by name. The path of a file gives only this file.

    Raises:
        InputError: the folder contains no task files.
    """
    if path.is_dir():
        files = sorted(file for file in path.iterdir() if file.name.endswith(ENDINGS) and file.is_file())
        if not files:
            hint = f"; its files of PDDL are pddl:{path}" if next(path.rglob("*.pddl"), None) else ""
            raise InputError(f"{path}: expected task files, *.jsonl or *.jsonl.gz{hint}")
        return files
    return [path]


def _read_content(file: Path) -> bytes:
    content = read_content(file)
    try:
        return gzip.decompress(content) if file.suffix == ".gz" else content
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(f"{file}: cannot be read ({getattr(error, 'strerror', None) or error})") from error


def _read_lines(file: Path, content: bytes) -> Iterator[_TaskFileLine]:
    return (_TaskFileLine(file, number, line) for number, line in number_lines(content))


def _read_task_id(place: _TaskFileLine) -> str:
    """Return the id of the task in a line. The line is parsed only if it does not begin with the id."""
    match = _LEADING_ID.match(place.content)
    if match is not None:
        return match[1].decode(errors="replace")
    try:
        value = json.loads(place.content)
    except ValueError as error:
        raise InputError(f"{place}: expected JSON ({error})") from error
    if not isinstance(value, dict) or not isinstance(value.get("id"), str):
        raise InputError(f'{place}: expected a task as a JSON object with the string "id"')
    return str(value["id"])
