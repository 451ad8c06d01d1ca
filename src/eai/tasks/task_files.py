"""Task files: tasks in the world of a benchmark, as JSON lines that people or `eai generate` wrote."""

from __future__ import annotations

import gzip
import hashlib
import json
import math
import re
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from eai.base.errors import InputError, prefix_errors_with_location
from eai.base.files import number_lines, read_content, write_files_atomically
from eai.base.grouping import MapItems, map_one_by_one
from eai.logic.ltl_printer import format_ltl
from eai.logic.start import is_refuted_by_initial_state
from eai.tasks.goal_test import GoalTest
from eai.tasks.planning import is_impossible
from eai.tasks.source import DataMistake, TaskSet
from eai.tasks.special import PossiblyImpossibleTaskMark
from eai.tasks.task import Task
from eai.tasks.task_lines import make_task_from_line, read_task_line
from eai.world.action import Action
from eai.world.domain import Domain
from eai.world.execution import Trajectory, describe_fault, execute_plan, to_trace
from eai.world.fault import FaultKind

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
        lines: mapping from the id of each task to its line, compressed, in the order of the files.
        sha256: SHA-256 digest of the content of all files.
    """

    name: str
    base: str
    lines: Mapping[str, _TaskFileLine]
    sha256: str

    def open_tasks(self, domain: Domain, max_kept: int | None = None) -> TaskSet[Task]:
        """Return the tasks in the files.

        Args:
            domain: the declaration of the tasks' benchmark.
            max_kept: maximum number of built tasks in memory (`TaskSet`).
        """

        def make_task(task_id: str) -> Task:
            return self._make_task(self.lines[task_id], domain)

        return TaskSet(self.lines, make_task, self.sha256, max_kept)

    def _make_task(self, file_line: _TaskFileLine, domain: Domain) -> Task:
        with prefix_errors_with_location(file_line):
            line = read_task_line(zlib.decompress(file_line.content))
            if line.base != self.base:
                raise InputError(f"base: expected {self.base!r}, as in the first line, found {line.base!r}")
            return make_task_from_line(line, domain)


def open_task_files(path: Path) -> _TaskFiles:
    """Return the tasks of a file, or of all task files in a folder, sorted by file name.

    Raises:
        InputError: there is no file or no task, a task's id is missing or repeated, or the first line is
            wrong. The message names file and line.
    """
    digest = hashlib.sha256()
    lines: dict[str, _TaskFileLine] = {}
    for number, file in enumerate(find_task_files(path)):
        content = _read_content(file)
        digest.update(b"\0" + content if number else content)
        for file_line in _read_lines(file, content):
            task_id = _read_task_id(file_line)
            if task_id in lines:
                raise InputError(f"{file_line}: the id {task_id!r} is already used at {lines[task_id]}")
            lines[task_id] = replace(file_line, content=zlib.compress(file_line.content, level=1))
    if not lines:
        raise InputError(f"{path}: expected at least one task")
    first = next(iter(lines.values()))
    with prefix_errors_with_location(first):
        base = read_task_line(zlib.decompress(first.content)).base
    name = path.resolve().name.removesuffix(".gz").removesuffix(".jsonl")
    return _TaskFiles(name, base, lines, digest.hexdigest())


def make_task_file_content(lines: Iterable[str]) -> bytes:
    """Return the content of a task file with these lines, before compression."""
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


class _TaskLineCheckResult(NamedTuple):
    """The mistakes in a line of a task file, and the id of its task: None if the line is not a task."""

    task_id: str | None
    problems: list[str]


def check_task_files(
    path: Path,
    domain_of: Callable[[str], Domain],
    find_more_mistakes: Callable[[str, Task], Iterable[str]],
    map_items: MapItems = map_one_by_one,
) -> Iterator[DataMistake]:
    """Yield all mistakes in task files: lines that are not tasks, and tasks with false statements.

    Args:
        path: a file or a folder.
        domain_of: returns the declaration of a benchmark, given the benchmark's name in a line.
        find_more_mistakes: finds mistakes in a task in which `find_mistakes_in_task` finds none, given the
            benchmark's name in its line.
        map_items: applies a function to the lines, for example in several processes.

    Raises:
        InputError: the files cannot be opened (`open_task_files`).
    """
    seen: dict[str, _TaskFileLine] = {}
    file_lines = list(read_task_file_lines(path))
    if not file_lines:
        yield DataMistake(str(path), "expected at least one task")
    check_lines = partial(_check_lines, domain_of, find_more_mistakes)
    for file_line, (task_id, problems) in zip(file_lines, map_items(check_lines, file_lines), strict=True):
        if task_id in seen:
            yield DataMistake(str(file_line), f"the id {task_id!r} is already used at {seen[task_id]}")
            continue
        if task_id is not None:
            seen[task_id] = file_line
        yield from (DataMistake(str(file_line), problem) for problem in problems)


def _check_lines(
    domain_of: Callable[[str], Domain],
    find_more_mistakes: Callable[[str, Task], Iterable[str]],
    file_lines: Sequence[_TaskFileLine],
) -> list[_TaskLineCheckResult]:
    return [_check_line(domain_of, find_more_mistakes, file_line) for file_line in file_lines]


def _check_line(
    domain_of: Callable[[str], Domain],
    find_more_mistakes: Callable[[str, Task], Iterable[str]],
    file_line: _TaskFileLine,
) -> _TaskLineCheckResult:
    task_id = None
    try:
        line = read_task_line(file_line.content)
        task_id = line.id
        domain = domain_of(line.base)
        task = make_task_from_line(line, domain)
        mistakes = list(find_mistakes_in_task(task, domain))
        return _TaskLineCheckResult(task_id, mistakes or list(find_more_mistakes(line.base, task)))
    except InputError as error:
        return _TaskLineCheckResult(task_id, [str(error)])


def find_mistakes_in_task(task: Task, domain: Domain) -> Iterator[str]:
    """Yield a message on each mistake in a task, such as a goal that holds at the start.

    Other mistakes are a plan that fails and a false statement on whether the task has a plan.
    """
    test = GoalTest(task)
    if all(test.evaluate_each_goal(task.initial, ())):
        yield "goals: expected a goal that does not hold at the start"
    yield from _find_false_claims_of_solvability(task, domain)
    if not task.has_no_plan:
        yield from _find_goals_violated_by_initial_state(task)
    for member, plan in _list_plans(task):
        yield from _find_mistakes_in_plan(member, plan, task, domain, test)
    lengths = {member: len(plan) for member, plan in _list_plans(task)}
    for member in ("plan", "reference"):
        if lengths.get("shortest", 0) > lengths.get(member, math.inf):
            number = lengths["shortest"]
            yield f"shortest: expected at most {lengths[member]} steps, as in {member}, found {number}"


def _list_plans(task: Task) -> Iterator[tuple[str, Sequence[Action]]]:
    """Yield the plans in a task's line of a task file, each with the name of its field, such as ``plan``."""
    plans = {"plan": task.script, "shortest": task.shortest_plan, "reference": task.reference_plan}
    yield from ((member, plan) for member, plan in plans.items() if plan)


def _find_mistakes_in_plan(
    member: str, plan: Sequence[Action], task: Task, domain: Domain, test: GoalTest
) -> Iterator[str]:
    """Yield a message for each step of a plan that fails or is needless, and for each unreached goal.

    Goals are not tested if a step fails. ``member`` is the plan's key in the task file. The plan with the key
    ``reference`` may have needless steps: it plays a game, in which an agent must first find the objects.
    """
    trajectory = execute_plan(domain, task.initial, plan)
    for number, step in enumerate(trajectory.steps):
        is_needless = step.fault is not None and step.fault.kind is FaultKind.ADDITIONAL_STEP
        if step.fault is not None and not (is_needless and member == "reference"):
            why = describe_fault(step.fault, domain, step.action, task.scene)
            what = f"{step.fault.kind.value}, {why}"
            yield f"{member}.{number}: expected a step that is possible and needed: {what}"
    if trajectory.failure is None:
        operators = [action.operator for action in trajectory.executed_actions]
        reached = test.evaluate_each_goal(trajectory.final_state, operators, trajectory)
        yield from (
            f"{member}: expected to reach goals.{number}"
            for number, is_met in enumerate(reached)
            if not is_met
        )


def _find_goals_violated_by_initial_state(task: Task) -> Iterator[str]:
    """Yield a message for each goal about the whole execution that the initial state already violates."""
    start = to_trace(Trajectory((task.initial,), ()))
    for number, goal in enumerate(task.goals):
        if goal.is_temporal and is_refuted_by_initial_state(goal.formula, start):
            yield f"goals.{number}: no plan reaches it: the start already breaks {format_ltl(goal.formula)}"


def _find_false_claims_of_solvability(task: Task, domain: Domain) -> Iterator[str]:
    """Yield messages if an `PossiblyImpossibleTaskMark` does not agree with the plans in a task's line.

    If the mark lists missing facts, the line must have no plan, and the task must be proved impossible. If
    the mark lists no missing fact, the task is solvable, and the line must have a ``plan``.
    """
    plans = list(_list_plans(task)) if task.has_no_plan else []
    for member, _ in plans:
        yield f"{member}: expected none, as the goals are out of reach for want of a fact"
    if task.has_no_plan and not plans and not is_impossible(task, domain):
        yield "missing: expected goals that are proved to be out of reach, found none"
    elif task.special == PossiblyImpossibleTaskMark(()) and not task.script:
        yield "missing: expected a plan, as nothing is missing"


def read_task_file_lines(path: Path) -> Iterator[_TaskFileLine]:
    """Yield the lines of a task file; or of all task files in a folder, sorted by file name.

    Raises:
        InputError: a file cannot be read.
    """
    return (
        file_line for file in find_task_files(path) for file_line in _read_lines(file, _read_content(file))
    )


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


def _read_task_id(file_line: _TaskFileLine) -> str:
    """Return the id of the task in a line. The line is parsed only if it does not begin with the id."""
    match = _LEADING_ID.match(file_line.content)
    if match is not None:
        return match[1].decode(errors="replace")
    try:
        value = json.loads(file_line.content)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{file_line}: expected JSON ({error})") from error
    if not isinstance(value, dict) or not isinstance(value.get("id"), str):
        raise InputError(f'{file_line}: expected a task as a JSON object with the string "id"')
    return str(value["id"])
