"""Write the prompts of an ability in a benchmark to a file, and choose tasks by name or at random."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Annotated, TypeVar

from eai.abilities.protocol import Ability
from eai.agents.setting import ACTING
from eai.base.entry_points import load_from_extension
from eai.base.errors import InputError, did_you_mean
from eai.base.files import write_files_atomically
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite, open_suite
from eai.cli.console import format_count, print_result
from eai.cli.options import make_flag, open_data_source, split_names
from eai.tasks.prompts.prompt import Prompt, PromptFiles, PromptSet

OfSet = Annotated[
    PromptSet, make_flag("--set", help="The data set's prompts, or ours (also in short, or only facts).")
]
TaskIds = Annotated[str, make_flag(help="Only these tasks, in this order: ids separated by commas.")]
Sample = Annotated[int | None, make_flag(help="So many of them, drawn at random.", min=1)]
SampleSeed = Annotated[int, make_flag(help="Which ones --sample draws.")]

SHORT = "short"
"""Value of ``--tasks`` that chooses the short test: some tasks that represent a suite."""

PAGE = ".html"
"""File extension of a page on which people answer prompts."""


def is_prompt_list_file(out: Path) -> bool:
    """Whether a file with this extension holds a list of prompts or a page for people, not training rows."""
    return out.suffix in (".json", PAGE)


def write_prompts(
    library: PromptLibrary,
    benchmark: Benchmark,
    ability: Ability,
    out: Path,
    select_prompts: Callable[..., dict[str, Prompt]] | None,
    goals: Path | None,
    *,
    as_json: bool,
) -> None:
    """Write the prompts of an ability in a benchmark as a list, or as a page on which people answer.

    Args:
        library: Source of prompts.
        benchmark: Benchmark of the tasks.
        ability: Ability that the prompts ask for.
        out: Output file.
        select_prompts: Function that selects prompts from a mapping by task id; None for all prompts. Its
            argument ``suite_name`` is the text by which its error message names the benchmark and ability.
        goals: File with a model's answers to goal interpretation. The prompts state the goals in these
            answers, and tasks without an answer have no prompt. If None, prompts state the tasks' own goals.
        as_json: Whether the summary is printed as JSON.

    Raises:
        InputError: A task does not exist, or the ability cannot be answered on a page.
    """
    source, is_page = library.source, out.suffix == PAGE
    is_plain = library.prompts == "official" and library.folder is None and goals is None
    is_whole = select_prompts is None and not is_page
    files = benchmark.official_files(ability, source) if is_plain and is_whole else None
    if files is None:
        asked = _make_prompts_by_task_id(library, benchmark, ability, goals)
        if select_prompts is not None:
            asked = select_prompts(asked, suite_name=f"{benchmark.name} {ability.value}")
        if is_page:
            page: str = load_from_extension("answer_form", f"--out {out}")(benchmark, ability, asked, source)
            write_files_atomically({out: page})
            made: Json = {"file": str(out), "questions": len(asked)}
            print_result(
                f"{format_count(len(asked), 'question')}; written to {out}", value=made, as_json=as_json
            )
            return
        files = PromptFiles.from_prompts(asked)
    beside = out.with_name(f"{out.stem}_system{out.suffix}")
    written = {out: files.prompts, **({} if files.system is None else {beside: files.system})}
    write_files_atomically(written)
    print_result(
        *(f"written to {path}" for path in written), value={"files": [*map(str, written)]}, as_json=as_json
    )


def _make_prompts_by_task_id(
    library: PromptLibrary, benchmark: Benchmark, ability: Ability, goals: Path | None
) -> Mapping[str, Prompt]:
    """Return the prompts of all tasks by task id.

    If ``goals`` is a file with a model's answers to goal interpretation, prompts state the goals in these
    answers. Tasks without such an answer then have no prompt.
    """
    if goals is None:
        return library.open(benchmark, ability)
    from eai.studies.pipeline.stage_one import read_interpreted_goals_for_prompts

    beliefs = read_interpreted_goals_for_prompts(goals, benchmark, ability, library.source).beliefs
    opened = library.open(benchmark, ability, beliefs)
    return {task_id: prompt for task_id, prompt in opened.items() if task_id in beliefs}


T = TypeVar("T")


def select_entries_of_tasks(
    entries: Mapping[str, T], tasks: str, sample: int | None, seed: int, suite_name: str
) -> dict[str, T]:
    """Return the entries of some tasks, or of a random sample of these tasks.

    Args:
        entries: the entries by task id.
        tasks: ids of tasks, separated by commas; empty for all tasks.
        sample: number of tasks to draw; None for all of them.
        seed: seed of the sample.
        suite_name: name of the benchmark and the ability in the error message.

    Raises:
        InputError: A task does not exist.
    """
    named = split_names(tasks) or list(entries)
    for task_id in named:
        if task_id not in entries:
            hint = did_you_mean(task_id, entries)
            raise InputError(f"--tasks: {task_id!r} is not a task of {suite_name}{hint}")
    draw = Random(seed)  # noqa: S311 - a sample, not a secret
    some = set(named if sample is None else draw.sample(named, min(sample, len(named))))
    return {task_id: entries[task_id] for task_id in dict.fromkeys(named) if task_id in some}


def open_suite_for_acting_and_select_tasks(
    domain: str, tasks: str, sample: int | None, seed: int, data: Path | None
) -> tuple[Suite, list[str]]:
    """Return a benchmark's suite for the ability acting, and ids of named tasks or of a random sample.

    Raises:
        InputError: The benchmark or a task does not exist.
    """
    with open_data_source(data) as source:
        suite = open_suite(domain, ACTING, source=source)
    ids = [task_id for task_id in suite.task_ids if tasks or suite.tasks[task_id].unplannable_reason is None]
    return suite, [
        *select_entries_of_tasks(dict.fromkeys(ids), tasks, sample, seed, f"{suite.domain} {ACTING.value}")
    ]


def select_tasks_of_suites(tasks: str, suites: Sequence[Suite], limit: int | None) -> list[list[str]]:
    """Return for each suite the tasks that ``--tasks`` names, or all tasks, up to a limit.

    A suite is an ability in a benchmark. The value ``short`` names the tasks of its short test.

    Raises:
        InputError: No suite has a task of a given name, or a suite has no short test.
    """
    if tasks == SHORT:
        wanted = [_list_task_ids_of_short_test(suite) for suite in suites]
    else:
        named = split_names(tasks)
        for task_id in named:
            if not any(task_id in suite.task_ids for suite in suites):
                only = f"{suites[0].domain} {suites[0].ability.value}" if len(suites) == 1 else "any suite"
                hint = did_you_mean(task_id, sorted({each for suite in suites for each in suite.task_ids}))
                raise InputError(f"--tasks: {task_id!r} is not a task of {only}{hint}")
        wanted = [named] * len(suites)
    pairs = zip(suites, map(set, wanted), strict=True)
    return [[each for each in suite.task_ids if not some or each in some][:limit] for suite, some in pairs]


def _list_task_ids_of_short_test(suite: Suite) -> Sequence[str]:
    task_ids: Sequence[str] = load_from_extension("short_tests", f"--tasks {SHORT}")(
        suite.domain, suite.ability
    )
    if not task_ids:
        raise InputError(
            f"--tasks {SHORT}: {suite.domain} {suite.ability.value} has no short test; give ids of tasks"
        )
    return task_ids
