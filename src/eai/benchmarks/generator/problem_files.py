"""Files with problems in BDDL or PDDL as tasks of a benchmark."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import eai.logic.formula as f
from eai.base.errors import InputError, prefix_errors, read_all
from eai.base.files import files_below
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.words import Words
from eai.logic.ltl_printer import print_ltl
from eai.pddl.bddl import parse_problem
from eai.pddl.check import Declarations, check_problem
from eai.pddl.files import ProblemFile, is_domain_file, read_problem_file, read_text, refuse
from eai.pddl.model import PddlDomain
from eai.pddl.reader import read_group
from eai.tasks.goal_text import check_goal, make_task
from eai.tasks.problem_world import ProblemWorld, declared_in_bddl, declared_in_pddl
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.world.condition import FormulaEvaluator
from eai.world.state import State

BDDL, PDDL = ".bddl", ".pddl"
"""How the names of files of problems end."""

_GAP = r"(?:\s|;[^\n]*)"
"""A space, or a comment, between two words."""


def problem_files_in(paths: Iterable[Path]) -> list[Path]:
    """Return the files of problems among some paths and below folders among them, each once.

    The files of a folder are sorted by name. A file in a folder that defines a domain is passed over.

    Raises:
        InputError: a folder has none, or a file ends otherwise.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            inside = files_below(path, f"*{BDDL}", f"*{PDDL}")
            files = [each for each in inside if not is_domain_file(each)]
            if not files:
                raise InputError(f"{path}: expected problems in files *{BDDL} or *{PDDL}")
            found += files
        elif path.suffix not in (BDDL, PDDL):
            raise InputError(f"{path}: expected a problem in a file *{BDDL} or *{PDDL}")
        else:
            found.append(path)
    return list(dict.fromkeys(found))


def read_problems(paths: Sequence[Path], benchmark: Benchmark, source: Source) -> list[Task]:
    """The tasks of some files, each known by the name of its problem, or by that of its file.

    PDDL is of the domain that `eai.pddl.export` makes of the declaration. BDDL has the declared names in
    small letters, or those of the data set where that has problems in BDDL. Goals are the parts of the
    outermost conjunction.

    Raises:
        InputError: a file cannot be read, or is no problem of this world; names file, line and what was
            expected.
    """
    endings = dict.fromkeys(path.suffix for path in paths)
    worlds = {ending: _world(ending, benchmark, source) for ending in endings}
    files = read_all(paths, lambda path: _read(path, worlds[path.suffix][0]))
    times = Counter(file.problem.name for file in files)
    tasks: dict[str, Path] = {}
    made = []
    for file in files:
        name = file.problem.name if times[file.problem.name] == 1 else file.path.stem
        if name in tasks:
            raise InputError(f"{file.path}: expected another name than {name!r}, as in {tasks[name]}")
        tasks[name] = file.path
        made.append(_task(name, file, worlds[file.path.suffix], benchmark))
    return made


def _world(ending: str, benchmark: Benchmark, source: Source) -> ProblemWorld:
    tasks = benchmark.tasks(source).values()
    if ending == PDDL:
        return declared_in_pddl(benchmark.domain, tasks)
    if benchmark.data.open_bddl is not None:
        return benchmark.data.open_bddl(source)
    return declared_in_bddl(benchmark.domain, tasks)


def _task(name: str, file: ProblemFile, world: ProblemWorld, benchmark: Benchmark) -> Task:
    _, pose = world
    initial, meaning = pose(file.problem)
    readings = FormulaEvaluator(benchmark.domain.vocabulary)
    facts: list[f.Formula] = [*file.problem.initial, *map(f.Not, file.problem.denied)]
    for each in facts:
        meant = _meant(meaning(each), initial, file, _line(file.text, each))
        if not readings.holds(meant, {}, initial):
            expected = f"expected facts that agree: with the others, {print_ltl(each)} does not hold"
            raise InputError(f"{file.path}: line {_line(file.text, each)}: {expected}")
    asked = file.problem.goal
    parts = f.operands(asked, f.And)
    line = file.text[: file.text.lower().find("(:goal")].count("\n") + 1
    goals = list(dict.fromkeys([_meant(meaning(part), initial, file, line) for part in parts]))
    if not goals:
        raise InputError(f"{file.path}: expected a goal")
    return make_task(name, _instruction(goals, initial, benchmark), initial, *goals)


def _meant(formula: f.Formula, initial: State, file: ProblemFile, line: int) -> f.Formula:
    """The meaning of what stands on a line, of which all is there: the agent of a problem may not be."""
    with prefix_errors(f"{file.path}: line {line}"):
        check_goal(formula, initial.scene)
    return formula


def _instruction(goals: Sequence[f.Formula], initial: State, benchmark: Benchmark) -> str:
    """The instruction, in English where there are words for it."""
    try:
        words = Words.of(benchmark, initial)
        return words.instruction(goals, random.Random(0))  # noqa: S311 - how it begins
    except (InputError, KeyError):
        return f"Reach a state in which all of this holds: {'; '.join(map(print_ltl, goals))}"


def _read(path: Path, header: PddlDomain) -> ProblemFile:
    if path.suffix == PDDL:
        return read_problem_file(path, header)
    text = read_text(path)
    with prefix_errors(path):
        problem = parse_problem(text)
        vocabulary = Declarations.of(header, problem.objects)
        refuse(text, read_group(text), check_problem(problem, header), vocabulary)
    return ProblemFile(problem, path, text)


def _line(text: str, fact: f.Formula) -> int:
    """The line on which a fact stands, or 1."""
    denied = rf"\(\s*not{_GAP}*" if isinstance(fact, f.Not) else ""
    atom = fact.operand if isinstance(fact, f.Not) else fact
    words = [atom.predicate, *(term.name for term in atom.arguments)] if isinstance(atom, f.Atom) else []
    pattern = rf"{denied}\({_GAP}*" + rf"{_GAP}+\??".join(map(re.escape, words)) + rf"{_GAP}*\)"
    found = re.search(pattern, text, re.IGNORECASE)
    return text.count("\n", 0, found.start() if found else 0) + 1
