"""The benchmarks there are: by name, as an object of a Python module, as PDDL files or as task files.

A distribution registers one by an entry point of the group ``eai.benchmarks``: a `Benchmark`, or a function
without arguments that returns one. What opens the other kinds is imported where one is asked for.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from traceback import extract_tb
from typing import TYPE_CHECKING, Any

from eai.abilities.protocol import Ability, find_abilities
from eai.base.entry_points import EntryPoint, get_entry_points
from eai.base.errors import EaiError, InputError, did_you_mean
from eai.base.files import files_below

if TYPE_CHECKING:
    from eai.benchmarks.benchmark import Benchmark
    from eai.tasks.source import OpenTasks, TaskSet
    from eai.tasks.task import Task

GROUP = "eai.benchmarks"
"""The group of entry points."""

PDDL = "pddl"
"""The word before the colon in a reference to PDDL files."""

OPENERS = "eai.openers"
"""The group of entry points of functions that open the rest of a reference ``word:rest``, by the word."""

REFERENCES = (
    "virtualhome, behavior, behavior-1k, another one by its name, module:object, pddl:DIR, pddl:FILE,DIR, "
    "alfworld:DIR, or task files, FILE.jsonl or DIR/"
)
"""How a benchmark is named, in words."""

_SUFFIXES = (".pddl", ".jsonl", ".gz")
"""How the names of files end whose change is noticed in a folder."""

CAPITALISED = {"virtualhome": "VirtualHome", "behavior": "Behavior"}
"""How identifiers with capitals spell the benchmarks of the paper."""

TITLES = CAPITALISED | {"behavior": "BEHAVIOR"}
"""How tables and pages spell them, so that records are shown without the worlds that they are about."""

FIRST = tuple(TITLES)
"""These benchmarks are the paper's, in its order; the others follow by name."""


@cache
def _entry_points() -> Mapping[str, EntryPoint]:
    return get_entry_points(GROUP, FIRST)


def registered() -> tuple[str, ...]:
    """The names of all registered benchmarks."""
    return tuple(_entry_points())


def of_the_paper() -> tuple[str, ...]:
    """The names of the paper's two households, as far as they are registered: the default of commands."""
    return tuple([name for name in registered() if name in FIRST])


def find_benchmark(reference: str) -> Benchmark:
    """The benchmark that a name, ``module:object``, ``pddl:DOMAIN,PROBLEMS`` or the path of task files means.

    A module is also looked for in the working directory. The problems of a domain in PDDL are in a file or a
    folder; ``pddl:FOLDER`` has the domain and its problems below it. ``alfworld:FOLDER`` has games of
    ALFWorld. A task file ends in ``.jsonl`` or ``.jsonl.gz``, or is in a folder, which is known by having a
    slash in its name. ``obfuscated:`` before any of them is its twin in other words, ``rules:`` the same
    prompts in its own words.

    It is loaded once, and again after its files of PDDL or tasks have changed.

    Raises:
        InputError: there is none, or it cannot be loaded.
    """
    return _find(reference, tuple(_versions(reference)))


def _versions(reference: str) -> Iterator[tuple[str, int, int]]:
    """The files of PDDL or tasks that a reference names, with what changes where their content does."""
    named = [] if reference in _entry_points() else re.split("[:,]", reference)
    is_pddl = PDDL in named[:-1]
    for path in map(Path, named):
        inside = (files_below(path, "*.pddl") if is_pddl else path.iterdir()) if path.is_dir() else ()
        for file in (path, *sorted(file for file in inside if file.suffix in _SUFFIXES)):
            if file.is_file():
                status = file.stat()
                yield str(file.resolve()), status.st_mtime_ns, status.st_size


def title_of(name: str) -> str:
    """Return the title of a benchmark in tables and pages; of an unknown one its name."""
    if name in TITLES or name not in registered():
        return TITLES.get(name, name)
    return find_benchmark(name).title


@cache
def _find(reference: str, versions: tuple[tuple[str, int, int], ...]) -> Benchmark:
    if reference in _entry_points():
        return _as_benchmark(_entry_points()[reference].load(), reference)
    module, separator, name = reference.partition(":")
    if _has_opener(reference):
        opener: Callable[[str], Benchmark] = get_entry_points(OPENERS)[module].load()
        return replace(opener(name), reference=reference)
    if is_task_files(reference):
        path = Path(reference)
        return replace(_open_own(path) or _open_tasks(path), reference=reference)
    if separator:
        return _as_benchmark(loaded(reference), reference)
    known = registered()
    expected = (
        f"{', '.join(known)}, module:object, pddl:DOMAIN,PROBLEMS, pddl:FOLDER or a folder of task files"
    )
    raise InputError(f"{reference!r} is no benchmark: expected {expected}{did_you_mean(reference, known)}")


def is_task_files(reference: str) -> bool:
    """Whether a reference is the path of a task file, or of a folder of them."""
    from eai.tasks.task_files import ENDINGS

    if _has_opener(reference):
        return False
    return reference.endswith((*ENDINGS, "/")) or Path(reference).is_dir()


def _has_opener(reference: str) -> bool:
    word, separator, _ = reference.partition(":")
    return bool(separator) and word in get_entry_points(OPENERS)


def open_pddl(files: str) -> Benchmark:
    """The benchmark of ``DOMAIN,PROBLEMS``, a file and a file or a folder, or of a folder that has both."""
    domain, separator, problems = files.partition(",")
    if not separator and not Path(domain).is_dir():
        expected = f"{PDDL}:DOMAIN,PROBLEMS, a file and a file or folder, or {PDDL}:FOLDER with both in it"
        raise InputError(f"{PDDL}:{files}: expected {expected}")
    from eai.abilities.notation.notation import Notation
    from eai.abilities.notation.plans import PddlPlans
    from eai.benchmarks.benchmark import Benchmark, DataSet
    from eai.tasks import problem_world

    paths = Path(domain), Path(problems)
    declared, tasks = problem_world.open_pddl(*paths) if separator else problem_world.open_folder(paths[0])
    copied = {
        Ability.GOAL_INTERPRETATION: "its instructions are the goals in PDDL, which need only be copied"
    }
    notation, data = Notation(PddlPlans()), DataSet(only_by_name=copied)
    return Benchmark(declared.name, declared, lambda source: tasks, notation, data)


def _open_own(path: Path) -> Benchmark | None:
    """The tasks in a file that an ability is asked of instead of a benchmark's; None if it has none."""
    from eai.abilities.declaration import declaration_of

    for ability in find_abilities() if path.is_file() else ():
        opener = declaration_of(ability).interaction.open_file
        if opener is not None and (own := opener(path)) is not None:
            return _benchmark_of(ability, *own)
    return None


def _benchmark_of(ability: Ability, name: str, tasks: TaskSet[Any]) -> Benchmark:
    """The benchmark that has tasks of an ability's own, and nothing else."""
    from eai.benchmarks.benchmark import Benchmark, DataSet
    from eai.tasks.source import given
    from eai.world.domain import Domain
    from eai.world.vocabulary import Vocabulary

    data = DataSet(own_tasks={ability: lambda source: tasks})
    return Benchmark(name, Domain(name, Vocabulary(()), ()), given(), data=data)


def _open_tasks(path: Path) -> Benchmark:
    """The benchmark of task files: the world of their base, with other tasks, scored as the paper says.

    Goals and subgoals are asked for where answers can be right: they can neither ask what is meant nor say
    that nothing leads there. Prompts and gold operators follow from the declaration.
    """
    from eai.tasks.task_files import open_task_files

    files = open_task_files(path)
    base = find_benchmark(files.base)
    return with_tasks(base, files.name, lambda source: files.tasks(base.domain))


def with_tasks(base: Benchmark, name: str, open_tasks: OpenTasks[Task]) -> Benchmark:
    """The benchmark of other tasks in the world of a base; it cannot be referred to.

    Args:
        base: the base.
        name: what sets these tasks apart, in the name of the benchmark.
        open_tasks: opens them.
    """
    from eai.benchmarks.errata import NO_ERRATA

    return replace(
        base,
        name=f"{base.name}-{name}",
        open_tasks=open_tasks,
        data=replace(
            base.data,
            title=f"{base.title}, {name}",
            errata=NO_ERRATA,
            prompts=None,
            task_id_of=str,
            own_tasks={},
            asks={
                Ability.GOAL_INTERPRETATION: lambda task: task.is_told_by_goals,
                Ability.SUBGOAL_DECOMPOSITION: lambda task: task.is_told_by_goals and not task.missing,
            },
            only_by_name={},
            open_public=base.open_tasks,
        ),
        reference="",
    )


def loaded(reference: str) -> Any:
    """The object that ``module:object`` names; the module may lie in the working directory.

    Raises:
        InputError: there is no such module or object, or what it declares is not sound.
    """
    module, _, name = reference.partition(":")
    here = str(Path.cwd())
    added = here not in sys.path
    if added:
        sys.path.insert(0, here)
    try:
        return getattr(import_module(module), name)
    except ImportError as error:
        raise InputError(f"{reference}: the module cannot be imported ({error})") from error
    except AttributeError as error:
        raise InputError(f"{reference}: {module} has no object {name!r}") from error
    except EaiError as error:  # the declaration in the module is not sound
        file = f"{module.replace('.', '/')}.py"
        frames = [each for each in extract_tb(error.__traceback__) if each.filename.endswith(file)]
        raise InputError(f"{file}: line {frames[-1].lineno}: {error}" if frames else str(error)) from error
    finally:
        if added:
            sys.path.remove(here)


def _as_benchmark(value: object, reference: str) -> Benchmark:
    from eai.benchmarks.benchmark import Benchmark

    found = value if isinstance(value, Benchmark) or not callable(value) else value()
    if not isinstance(found, Benchmark):
        raise InputError(f"{reference}: expected a Benchmark, found {type(found).__name__}")
    return replace(found, reference=reference)
