"""Find benchmarks by name, as an object of a Python module, as PDDL files or as task files.

A distribution registers a benchmark by an entry point of the group ``eai.benchmarks``: a `Benchmark`, or a
function without arguments that returns one. Functions for other references, such as ``pddl:...``, are
imported on first use.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, lru_cache, partial
from importlib import import_module
from pathlib import Path
from traceback import TracebackException, extract_tb
from typing import TYPE_CHECKING, Any

from eai.abilities.protocol import Ability, find_ability_entry_points
from eai.base.entry_points import EntryPoint, describe_exit, get_entry_points
from eai.base.errors import EaiError, InputError, did_you_mean
from eai.base.files import find_files_below

if TYPE_CHECKING:
    from eai.benchmarks.benchmark import Benchmark
    from eai.tasks.source import OpenTasks, TaskSet
    from eai.tasks.task import Task

GROUP = "eai.benchmarks"
"""Group of the entry points of benchmarks."""

PDDL = "pddl"
"""Word before the colon in references to benchmarks in PDDL files."""

OPENERS = "eai.openers"
"""Group of entry points whose functions load the benchmark for a reference ``word:rest``.

The name of the entry point is ``word``.
"""

REFERENCES = (
    "virtualhome, behavior, behavior-1k, another one by its name, module:object, pddl:DIR, pddl:FILE,DIR, "
    "alfworld:DIR, behavior-1k:DIR, or task files, FILE.jsonl or DIR/"
)
"""Forms of references to benchmarks, for messages and help texts."""

_SUFFIXES = (".pddl", ".jsonl", ".gz")
"""Suffixes of files in the folder of a benchmark. If such a file changes, the benchmark is loaded again."""

_MAX_CACHED_VERSIONS = 32
"""Maximum number of loaded benchmarks in memory. Each version of a changed file gives another benchmark."""

CAPITALISED = {"virtualhome": "VirtualHome", "behavior": "Behavior"}
"""Name of each benchmark of the paper -> name with capital letters, as in identifiers."""

TITLES = CAPITALISED | {"behavior": "BEHAVIOR"}
"""Name of each benchmark of the paper -> title on pages. This table avoids loading the benchmark."""

PAPER_BENCHMARKS = tuple(TITLES)
"""Names of the paper's benchmarks, in the paper's order.

Lists show these benchmarks first, and then other benchmarks by name.
"""


@cache
def _get_entry_points() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, PAPER_BENCHMARKS)


def list_benchmarks() -> tuple[str, ...]:
    """Return the names of all registered benchmarks."""
    return tuple(_get_entry_points())


def list_paper_benchmarks() -> tuple[str, ...]:
    """Return the names of the paper's benchmarks, if registered. They are the default of commands."""
    return tuple([name for name in list_benchmarks() if name in PAPER_BENCHMARKS])


def find_benchmark(reference: str) -> Benchmark:
    """Return the benchmark for a reference.

    A reference is a name, ``module:object``, ``pddl:DOMAIN,PROBLEMS`` or a path of task files.

    A module is also searched in the working directory. The problems of a PDDL domain are in a file or a
    folder; ``pddl:FOLDER`` has the domain and its problems somewhere below it. ``alfworld:FOLDER`` contains
    games of ALFWorld, and ``behavior-1k:FOLDER`` definitions of BEHAVIOR-1K's repository. The name of a task
    file ends in ``.jsonl`` or ``.jsonl.gz``. A folder of task files is recognized by a slash in its name.
    ``obfuscated:`` before a reference means the benchmark with other words. ``rules:`` means the prompts of
    the obfuscated benchmark with the original words.

    A benchmark is loaded once, and again after its PDDL files, its task files or files of the benchmark on
    which they build (their base) have changed.

    Raises:
        InputError: there is no such benchmark, or it cannot be loaded.
    """
    return _load_benchmark_cached_by_file_times(reference, tuple(_list_paths_times_and_sizes(reference)))


def _list_paths_times_and_sizes(reference: str) -> Iterator[tuple[str, int, int]]:
    """Yield path, time of change and size of each file of a benchmark, and of the base of its task files.

    If a later call yields other values, a file has changed, and the benchmark must be loaded again.
    """
    named = [] if reference in _get_entry_points() else re.split("[:,]", reference)
    is_pddl = PDDL in named[:-1]
    for path in [Path(name.strip() if is_pddl else name) for name in named]:
        inside = (find_files_below(path, "*.pddl") if is_pddl else path.iterdir()) if path.is_dir() else ()
        files = [path, *sorted(file for file in inside if file.suffix in _SUFFIXES)]
        statuses = [(str(file.resolve()), file.stat()) for file in files if file.is_file()]
        times_and_sizes = tuple([(name, status.st_mtime_ns, status.st_size) for name, status in statuses])
        yield from times_and_sizes
        if not is_pddl and times_and_sizes and (base := _read_base_of_task_files(path, times_and_sizes)):
            yield from _list_paths_times_and_sizes(base)


@lru_cache(_MAX_CACHED_VERSIONS)
def _read_base_of_task_files(path: Path, file_times_and_sizes: tuple[tuple[str, int, int], ...]) -> str:
    """Return the reference to the base of task files, or "" if their first line cannot be read as a task.

    A changed file has other times and sizes, so that it is read again.
    """
    from eai.tasks.task_files import read_task_file_lines
    from eai.tasks.task_lines import read_task_line

    try:
        first = next(read_task_file_lines(path), None)
        return "" if first is None else read_task_line(first.content).base
    except InputError:
        return ""  # loading the benchmark reports the error, unless the path has files of another kind


def get_title(name: str) -> str:
    """Return the title of a benchmark in tables and pages, or its name if the benchmark is unknown."""
    if name in TITLES or name not in list_benchmarks():
        return TITLES.get(name, name)
    return find_benchmark(name).title


@lru_cache(_MAX_CACHED_VERSIONS)
def _load_benchmark_cached_by_file_times(
    reference: str, file_times_and_sizes: tuple[tuple[str, int, int], ...]
) -> Benchmark:
    if reference in _get_entry_points():
        return _require_benchmark(_get_entry_points()[reference].load(), reference)
    module, separator, name = reference.partition(":")
    if _has_registered_benchmark_opener(reference):
        opener: Callable[[str], Benchmark] = get_entry_points(OPENERS)[module].load()
        return replace(opener(name), reference=reference)
    if reference.partition(",")[0].endswith(f".{PDDL}"):
        raise InputError(
            f"{reference}: files of PDDL are given as {PDDL}:DOMAIN,PROBLEMS; put {PDDL}: in front"
        )
    if is_path_of_task_files(reference):
        path = Path(reference)
        return replace(_open_task_file_of_single_ability(path) or _open_task_files(path), reference=reference)
    if separator or reference.endswith(".py"):
        return _require_benchmark(load_object(reference), reference)
    names = list_benchmarks()
    expected = (
        f"{', '.join(names)}, module:object, pddl:DOMAIN,PROBLEMS, pddl:FOLDER or a folder of task files"
    )
    raise InputError(f"{reference!r} is not a benchmark: expected {expected}{did_you_mean(reference, names)}")


def is_path_of_task_files(reference: str) -> bool:
    """Whether a reference is the path of a task file, or of a folder of task files."""
    from eai.tasks.task_files import ENDINGS

    if _has_registered_benchmark_opener(reference):
        return False
    return reference.endswith((*ENDINGS, "/")) or Path(reference).is_dir()


def _has_registered_benchmark_opener(reference: str) -> bool:
    word, separator, _ = reference.partition(":")
    return bool(separator) and word in get_entry_points(OPENERS)


def open_pddl_benchmark(files: str) -> Benchmark:
    """Return the benchmark of ``DOMAIN,PROBLEMS``, or of a folder that has both.

    ``DOMAIN`` is the path of a PDDL file; ``PROBLEMS`` is the path of a file or a folder.
    """
    domain, separator, problems = files.partition(",")
    if not separator and not Path(domain).is_dir():
        expected = f"{PDDL}:DOMAIN,PROBLEMS, a file and a file or folder, or {PDDL}:FOLDER with both in it"
        raise InputError(f"{PDDL}:{files}: expected {expected}")
    from eai.abilities.notation.notation import Notation
    from eai.abilities.notation.plans import PddlPlanNotation
    from eai.benchmarks.benchmark import Benchmark, DataSet
    from eai.tasks import problem_world

    paths = Path(domain.strip()), Path(problems.strip())
    declared, tasks = (
        problem_world.open_pddl(*paths) if separator else problem_world.open_pddl_folder(paths[0])
    )
    copied = {
        Ability.GOAL_INTERPRETATION: "its instructions are the goals in PDDL, which need only be copied"
    }
    notation, data = Notation(PddlPlanNotation()), DataSet(only_by_name=copied)
    return Benchmark(declared.name, declared, lambda source: tasks, notation, data)


def _open_task_file_of_single_ability(path: Path) -> Benchmark | None:
    """Return the benchmark of a file with tasks that are made for one ability, or None for other files."""
    from eai.abilities.declaration import get_declaration

    for ability in find_ability_entry_points() if path.is_file() else ():
        opener = get_declaration(ability).interaction.open_file
        if opener is not None and (tasks := opener(path)) is not None:
            return _make_single_ability_benchmark(ability, *tasks)
    return None


def _make_single_ability_benchmark(ability: Ability, name: str, tasks: TaskSet[Any]) -> Benchmark:
    from eai.benchmarks.benchmark import Benchmark, DataSet
    from eai.tasks.source import use_tasks
    from eai.world.domain import Domain
    from eai.world.vocabulary import Vocabulary

    data = DataSet(own_tasks={ability: lambda source: tasks})
    return Benchmark(name, Domain(name, Vocabulary(()), ()), use_tasks(), data=data)


def _open_task_files(path: Path) -> Benchmark:
    """Return the benchmark of task files. The tasks are new; the domain comes from another benchmark.

    Goal interpretation and subgoal decomposition leave out tasks whose prompts give only an ambiguous
    instruction. Subgoal decomposition also leaves out tasks that have no plan. Prompts and gold operators are
    made from the domain, because none are published.
    """
    from eai.tasks.task_files import open_task_files

    files = open_task_files(path)
    base = find_benchmark(files.base)
    open_tasks = cache(partial(files.open_tasks, base.domain))
    return make_benchmark_with_other_tasks(base, files.name, lambda source: open_tasks(source.kept))


def make_benchmark_with_other_tasks(base: Benchmark, name: str, open_tasks: OpenTasks[Task]) -> Benchmark:
    """Return a benchmark with the domain of a base benchmark and other tasks.

    No reference (text for `find_benchmark`) names this benchmark.

    Args:
        base: the base benchmark.
        name: name that is added to the base benchmark's name.
        open_tasks: returns the tasks.
    """
    from eai.benchmarks.benchmark import DataSet

    published = base.data
    data = DataSet(
        f"{base.title}, {name}",
        asks={
            Ability.GOAL_INTERPRETATION: lambda task: task.has_goals_in_prompts,
            Ability.SUBGOAL_DECOMPOSITION: lambda task: task.has_goals_in_prompts and not task.has_no_plan,
        },
        open_public=base.open_tasks,
        open_demonstrations=published.open_demonstrations,
        open_bddl=published.open_bddl,
        planner_seconds=published.planner_seconds,
        labels=published.labels,
    )
    return replace(base, name=f"{base.name}-{name}", open_tasks=open_tasks, data=data, reference="")


def load_object(reference: str) -> Any:
    """Return the object that ``module:object`` names. The module may be in the working directory.

    Raises:
        InputError: the module or the object does not exist, or the module raises an exception.
    """
    module, _, name = reference.partition(":")
    if module.endswith(".py") or not all(map(str.isidentifier, module.split("."))):
        raise InputError(f"{reference}: expected a module without folder and .py, as in lamps:lamps")
    here = str(Path.cwd())
    added = here not in sys.path
    if added:
        sys.path.insert(0, here)
    try:
        imported = import_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(_describe_import_error(module, reference, error)) from error
    finally:
        if added:
            sys.path.remove(here)
    try:
        return getattr(imported, name)
    except AttributeError as error:
        is_folder = getattr(imported, "__file__", "") is None
        hint = f"; it is a folder: run the command in the folder of {module}.py" if is_folder else ""
        raise InputError(f"{reference}: {module} has no object {name!r}{hint}") from error


def _describe_import_error(module: str, reference: str, error: Exception | SystemExit) -> str:
    """Return a message about an exception during an import, with the line of the module that raised it."""
    file = f"{module.replace('.', '/')}.py"
    lines = [
        frame.lineno
        for frame in extract_tb(error.__traceback__)
        if f"/{Path(frame.filename).as_posix()}".endswith(f"/{file}")
    ]
    if isinstance(error, SyntaxError) and error.filename:
        file, lines = Path(error.filename).name, [error.lineno]
    if isinstance(error, EaiError):
        text = str(error)
    elif isinstance(error, ImportError) and not lines:
        text = f"the module cannot be imported ({error})"
    elif isinstance(error, SystemExit):
        text = describe_exit(error)
    else:  # show the last line of the traceback, because it has Python's suggestion of a name
        text = list(TracebackException.from_exception(error).format_exception_only())[-1].strip()
    if lines:
        return f"{file}: line {lines[-1]}: {text}"
    return text if isinstance(error, EaiError) else f"{reference}: {text}"


def _require_benchmark(value: object, reference: str) -> Benchmark:
    from eai.benchmarks.benchmark import Benchmark

    benchmark = value if isinstance(value, Benchmark) or not callable(value) else value()
    if not isinstance(benchmark, Benchmark):
        raise InputError(f"{reference}: expected a Benchmark, found {type(benchmark).__name__}")
    return replace(benchmark, reference=reference)
