"""Read problem files in BDDL or PDDL as tasks of a benchmark."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import eai.logic.formula as f
from eai.base.errors import InputError, prefix_errors_with_location, read_items_or_raise_all
from eai.base.files import find_files_below
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.words import InstructionWriter
from eai.logic.ltl_printer import format_ltl
from eai.pddl.bddl import parse_problem
from eai.pddl.check import PddlDeclarations, check_problem
from eai.pddl.files import (
    ProblemFile,
    blank_out_comments,
    is_domain_file,
    raise_for_findings,
    read_problem_file,
    read_text,
)
from eai.pddl.model import PddlDomain
from eai.pddl.reader import read_group
from eai.tasks.goal_text import check_goal_names, make_task
from eai.tasks.problem_world import (
    DomainAndProblemReader,
    assign_task_names,
    make_bddl_domain_and_reader,
    make_pddl_domain_and_reader,
)
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.condition import FormulaEvaluator
from eai.world.state import State

BDDL, PDDL = ".bddl", ".pddl"
"""Suffixes of names of problem files."""


def find_problem_files(paths: Iterable[Path]) -> list[Path]:
    """Return the problem files among paths, and at any depth below folders among them, without duplicates.

    The files of a folder are sorted by name. A file in a folder is skipped if it defines a domain.

    Raises:
        InputError: a folder has no problem file, or a file has another suffix.
    """
    problem_files: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = find_files_below(path, f"*{BDDL}", f"*{PDDL}")
            files = [file for file in inside if not is_domain_file(file)]
            if not files:
                raise InputError(f"{path}: expected problems in files *{BDDL} or *{PDDL}")
            problem_files += files
        elif path.suffix not in (BDDL, PDDL):
            raise InputError(f"{path}: expected a problem in a file *{BDDL} or *{PDDL}")
        else:
            problem_files.append(path)
    return list(dict.fromkeys(problem_files))


def read_problems(paths: Sequence[Path], benchmark: Benchmark, source: Source) -> list[Task]:
    """Return the tasks in problem files. Each operand of the outermost conjunction becomes a goal.

    A task is named after its problem. If problems have equal names, their tasks are named after their files.
    PDDL problems use the domain that `eai.pddl.export` makes of the declaration. BDDL problems use the names
    in the data set's own BDDL problems. If the data set has no BDDL problems, its declared names are used in
    small letters.

    Raises:
        InputError: a file cannot be read, or its problem does not fit this benchmark; the message names file,
            line and the expected text.
    """
    endings = dict.fromkeys(path.suffix for path in paths)
    worlds = {ending: _open_problem_reader(ending, benchmark, source) for ending in endings}
    files = read_items_or_raise_all(paths, lambda path: _read_problem_file(path, worlds[path.suffix][0]))
    return [
        _make_task(name, file, worlds[file.path.suffix], benchmark)
        for name, file in assign_task_names(files).items()
    ]


def _open_problem_reader(suffix: str, benchmark: Benchmark, source: Source) -> DomainAndProblemReader:
    tasks = benchmark.tasks(source).values()
    if suffix == PDDL:
        return make_pddl_domain_and_reader(benchmark.domain, tasks)
    if benchmark.data.open_bddl is not None:
        return benchmark.data.open_bddl(source)
    return make_bddl_domain_and_reader(benchmark.domain, tasks)


def _make_task(name: str, file: ProblemFile, world: DomainAndProblemReader, benchmark: Benchmark) -> Task:
    _, pose = world
    initial, meaning = pose(file.problem)
    readings = FormulaEvaluator(benchmark.domain.vocabulary)
    facts: list[f.Formula] = [*file.problem.initial, *map(f.Not, file.problem.denied)]
    for each in facts:
        line = _find_line_of_fact(file.text, each)
        meant = _require_known_names(meaning(each), initial, file, line)
        if not readings.holds(meant, {}, initial):
            raise InputError(
                f"{file.path}: line {line}: {format_ltl(each)} is stated, but is false in the state that all "
                "facts define; remove it, or the facts that contradict it"
            )
    asked = file.problem.goal
    parts = f.get_operands(asked, f.And)
    line = _find_line_of_pattern(file.text, r"\(\s*:goal")
    goals = list(dict.fromkeys([_require_known_names(meaning(part), initial, file, line) for part in parts]))
    if not goals:
        raise InputError(f"{file.path}: the goal is empty; write a condition after (:goal")
    return make_task(name, _make_instruction(goals, initial, benchmark), initial, *goals)


def _require_known_names(formula: f.Formula, initial: State, file: ProblemFile, line: int) -> f.Formula:
    """Return a fact or goal of a problem file unchanged, if the scene has every name in it.

    Raises InputError with the line for an unknown name, such as the agent in a problem without an agent.
    """
    with prefix_errors_with_location(f"{file.path}: line {line}"):
        check_goal_names(formula, initial.scene)
    return formula


def _make_instruction(goals: Sequence[f.Formula], initial: State, benchmark: Benchmark) -> str:
    try:
        words = InstructionWriter.make_writer_for_benchmark(benchmark, initial)
        return words.make_instruction(goals, random.Random(0))  # noqa: S311 - draws the opening words
    except (InputError, KeyError):
        return f"Reach a state in which all of this holds: {'; '.join(map(format_ltl, goals))}"


def _read_problem_file(path: Path, domain: PddlDomain) -> ProblemFile:
    if path.suffix == PDDL:
        return read_problem_file(path, domain)
    text = read_text(path)
    with prefix_errors_with_location(path):
        problem = parse_problem(text)
        vocabulary = PddlDeclarations.from_domain(domain, problem.objects)
        raise_for_findings(text, read_group(text), check_problem(problem, domain), vocabulary)
    return ProblemFile(problem, path, text)


def _find_line_of_fact(text: str, fact: f.Formula) -> int:
    """Return the number of the line that contains a fact, or 1 if no line contains the fact."""
    denied = r"\(\s*not\s*" if isinstance(fact, f.Not) else ""
    atom = fact.operand if isinstance(fact, f.Not) else fact
    words = [atom.predicate, *(term.name for term in atom.arguments)] if isinstance(atom, f.Atom) else []
    pattern = rf"{denied}\(\s*" + r"\s+\??".join(map(re.escape, words)) + r"\s*\)"
    return _find_line_of_pattern(text, pattern)


def _find_line_of_pattern(text: str, pattern: str) -> int:
    match = re.search(pattern, blank_out_comments(text), re.IGNORECASE)
    return text.count("\n", 0, match.start() if match else 0) + 1
