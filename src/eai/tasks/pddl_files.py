"""PDDL files as a declared domain and its tasks."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from eai.abilities.task import Goal, GoalKind, Task
from eai.errors import DomainError, InputError
from eai.logic.formula import Atom, Formula
from eai.logic.traversal import walk
from eai.pddl.declaration import DeclaredDomain
from eai.pddl.files import DomainFile, ProblemFile, read_domain_file, read_problem_file
from eai.pddl.writer import write_formula
from eai.tasks.source import TaskSet
from eai.world.domain import Domain


def open_pddl(domain_file: Path, problems: Path) -> tuple[Domain, TaskSet[Task]]:
    """The domain in a file, and the problems in another or in all ``.pddl`` files of a folder, by name.

    A task is known by the name of its problem, or by that of the file where problems share one.

    Raises:
        InputError: a file cannot be read; the message names it, the line and what was expected.
    """
    read = read_domain_file(domain_file)
    declaration = _declare(read)
    files = [read_problem_file(path, read.domain) for path in _problem_paths(domain_file, problems)]
    names = Counter(file.problem.name for file in files)
    tasks: dict[str, Task] = {}
    for file in files:
        name = file.problem.name if names[file.problem.name] == 1 else file.path.stem
        tasks[name] = _task(name, file, declaration)
    texts = [read.text, *(f"{name}\0{file.text}" for name, file in zip(tasks, files, strict=True))]
    digest = hashlib.sha256("\0".join(texts).encode()).hexdigest()
    return declaration.domain, TaskSet(tasks, tasks.__getitem__, digest)


def _declare(read: DomainFile) -> DeclaredDomain:
    try:
        return DeclaredDomain(read.domain)
    except DomainError as error:
        named = next((p.name for p in read.domain.predicates if f" {p.name} " in str(error)), "")
        raise InputError(f"{read.path}: line {read.line(f'({named}')}: {error}") from error


def _problem_paths(domain_file: Path, problems: Path) -> Sequence[Path]:
    if not problems.is_dir():
        return (problems,)
    inside = (path for path in problems.glob("*.pddl") if path.is_file())
    found = sorted(path for path in inside if path.resolve() != domain_file.resolve())
    if not found:
        raise InputError(f"{problems}: expected problems in files *.pddl")
    return found


def _task(name: str, file: ProblemFile, declaration: DeclaredDomain) -> Task:
    declared = declaration.problem(file.problem)
    wanted = "; ".join(write_formula(goal) for goal in declared.goals)
    return Task(
        id=name,
        title=name,
        instruction=f"Reach a state in which all of this holds: {wanted}",
        initial=declared.initial,
        goals=tuple([Goal(_kind(goal), goal) for goal in dict.fromkeys(declared.goals)]),
        relevant=tuple(range(len(declared.initial.scene.objects))),
    )


def _kind(formula: Formula) -> GoalKind:
    """Relation if the goal speaks of any, else state."""
    binary = any(isinstance(part, Atom) and len(part.arguments) == 2 for part in walk(formula))
    return GoalKind.RELATION if binary else GoalKind.STATE
