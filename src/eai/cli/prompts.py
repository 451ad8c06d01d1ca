"""The prompts of a suite as a file, and the tasks that commands name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Annotated, TypeVar

from eai.abilities.protocol import Ability
from eai.agents.setting import ACTING
from eai.base.entry_points import load_offer
from eai.base.errors import InputError, did_you_mean
from eai.base.files import write_whole
from eai.base.json_value import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.suite import Suite, open_suite
from eai.cli.console import counted, tell
from eai.cli.options import flag, listed, opened_source
from eai.tasks.prompts.prompt import Prompt, PromptFiles, PromptSet

OfSet = Annotated[PromptSet, flag("--set", help="The data set's prompts, or ours (in three wordings).")]
TaskIds = Annotated[str, flag(help="Only these tasks, in this order: ids separated by commas.")]
Sample = Annotated[int | None, flag(help="So many of them, drawn at random.", min=1)]
SampleSeed = Annotated[int, flag(help="Which ones --sample draws.")]

SHORT = "short"
"""The name of the short test of a suite, in the place of task ids."""

PAGE = ".html"
"""The ending of a file that is a page for people."""


def is_list(out: Path) -> bool:
    """Whether prompts go to such a file as a list, or as a page for people, and not as rows for training."""
    return out.suffix in (".json", PAGE)


def write_prompts(
    library: Library,
    benchmark: Benchmark,
    ability: Ability,
    out: Path,
    chosen: Callable[..., dict[str, Prompt]] | None,
    goals: Path | None,
    *,
    as_json: bool,
) -> None:
    """Write the prompts of a suite as a list, or as a page on which people answer.

    Args:
        library: where prompts are from.
        benchmark: the benchmark.
        ability: what is asked for.
        out: the file.
        chosen: makes of prompts and the name of their suite those that are wanted (`drawn`); all if None.
        goals: answers to goal interpretation whose goals are stated, to the tasks that they are about.
        as_json: print what was written as JSON.

    Raises:
        InputError: there is no such task, or people cannot answer on a page.
    """
    source, is_page = library.source, out.suffix == PAGE
    is_plain = library.prompts == "official" and library.folder is None and goals is None
    is_whole = chosen is None and not is_page
    files = benchmark.official_files(ability, source) if is_plain and is_whole else None
    if files is None:
        asked = _opened(library, benchmark, ability, goals)
        asked = chosen(asked, of=f"{benchmark.name} {ability.value}") if chosen else asked
        if is_page:
            page: str = load_offer("answer_form", f"--out {out}")(benchmark, ability, asked, source)
            write_whole({out: page})
            made: Json = {"file": str(out), "questions": len(asked)}
            tell(f"{counted(len(asked), 'question')}; written to {out}", value=made, as_json=as_json)
            return
        files = PromptFiles.from_prompts(asked)
    beside = out.with_name(f"{out.stem}_system{out.suffix}")
    written = {out: files.prompts, **({} if files.system is None else {beside: files.system})}
    write_whole(written)
    tell(*(f"written to {path}" for path in written), value={"files": [*map(str, written)]}, as_json=as_json)


def _opened(
    library: Library, benchmark: Benchmark, ability: Ability, goals: Path | None
) -> Mapping[str, Prompt]:
    """All prompts, or those with the goals of answers to goal interpretation."""
    if goals is None:
        return library.open(benchmark, ability)
    from eai.studies.pipeline.stage_one import read_goal_beliefs

    beliefs = read_goal_beliefs(goals, benchmark, ability, library.source).beliefs
    opened = library.open(benchmark, ability, beliefs)
    return {task_id: prompt for task_id, prompt in opened.items() if task_id in beliefs}


T = TypeVar("T")


def drawn(asked: Mapping[str, T], tasks: str, sample: int | None, seed: int, of: str) -> dict[str, T]:
    """The values of the tasks that are named, or of so many of them.

    Raises:
        InputError: there is no such task.
    """
    named = listed(tasks) or list(asked)
    for task_id in named:
        if task_id not in asked:
            raise InputError(f"--tasks: {task_id!r} is not a task of {of}{did_you_mean(task_id, asked)}")
    draw = Random(seed)  # noqa: S311 - a sample, not a secret
    some = set(named if sample is None else draw.sample(named, min(sample, len(named))))
    return {task_id: asked[task_id] for task_id in dict.fromkeys(named) if task_id in some}


def playable(
    domain: str, tasks: str, sample: int | None, seed: int, data: Path | None
) -> tuple[Suite, list[str]]:
    """The tasks of a benchmark as they are acted in, and the ids of those that are named, or of a sample.

    Raises:
        InputError: there is no such benchmark or task.
    """
    with opened_source(data) as source:
        suite = open_suite(domain, ACTING, source=source)
    ids = [task_id for task_id in suite.task_ids if tasks or suite.tasks[task_id].plan_exclusion is None]
    return suite, [*drawn(dict.fromkeys(ids), tasks, sample, seed, f"{suite.domain} {ACTING.value}")]


def tasks_of(tasks: str, suites: Sequence[Suite], limit: int | None) -> list[list[str]]:
    """For each suite those of its tasks that ``--tasks`` names, so many at most; of all, if it names none.

    Raises:
        InputError: no suite has a task of this name, or one has no short test.
    """
    if tasks == SHORT:
        wanted = [_short(suite) for suite in suites]
    else:
        named = listed(tasks)
        for task_id in named:
            if not any(task_id in suite.task_ids for suite in suites):
                only = f"{suites[0].domain} {suites[0].ability.value}" if len(suites) == 1 else "any suite"
                hint = did_you_mean(task_id, sorted({each for suite in suites for each in suite.task_ids}))
                raise InputError(f"--tasks: {task_id!r} is not a task of {only}{hint}")
        wanted = [named] * len(suites)
    pairs = zip(suites, map(set, wanted), strict=True)
    return [[each for each in suite.task_ids if not some or each in some][:limit] for suite, some in pairs]


def _short(suite: Suite) -> Sequence[str]:
    found: Sequence[str] = load_offer("short_tests", f"--tasks {SHORT}")(suite.domain, suite.ability)
    if not found:
        raise InputError(f"--tasks {SHORT}: {suite.domain} {suite.ability.value} has no short test")
    return found
