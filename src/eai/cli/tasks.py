"""``eai check`` and ``eai export tasks``: check benchmarks and task files, and write task files."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from eai.abilities.protocol import Ability
from eai.agents.reference import add_reference_plans, describe_wrong_recorded_plans
from eai.base.errors import InputError
from eai.base.grouping import MapItems
from eai.base.json_value import Json
from eai.benchmarks.check import check_benchmark
from eai.benchmarks.generator.problem_files import find_problem_files, read_problems
from eai.benchmarks.generator.sets import find_reasons_to_doubt_published_set, measure_overlap
from eai.benchmarks.registry import PDDL, REFERENCES, find_benchmark, is_path_of_task_files
from eai.cli.console import DOMAIN_HELP, format_count, print_findings_and_exit, print_result
from eai.cli.learnability import print_learnability_of_rewards
from eai.cli.options import (
    ABILITIES,
    AsJson,
    DataFolder,
    OnRay,
    Workers,
    make_flag,
    open_data_source,
    open_scoring_workers,
)
from eai.cli.progress import show_scoring_progress
from eai.cli.prompts import OfSet
from eai.planning.search import SearchEndReason
from eai.results.reward import Shaping
from eai.results.workers import WorkerPool
from eai.tasks.source import DataMistake
from eai.tasks.task import Task
from eai.tasks.task_files import check_task_files, find_task_files, read_task_file_lines, write_task_file
from eai.tasks.task_lines import (
    get_recorded_plan_fields,
    make_task_from_line,
    make_task_line_schema,
    read_task_line,
    write_task_line,
)
from eai.world.domain import Domain

_LEARNABLE = "With --learnable"


def check(
    path: Annotated[str, typer.Argument(metavar="REFERENCE", help=DOMAIN_HELP)] = "",
    against: Annotated[str | None, make_flag(metavar="NAME")] = None,
    split: str | None = None,
    secret: Annotated[str, make_flag(envvar="EAI_SECRET")] = "",
    schema: bool = False,
    references: bool = False,
    learnable: Annotated[bool, make_flag("--learnable")] = False,
    ability: Annotated[
        Ability, make_flag(panel=_LEARNABLE, help=f"{ABILITIES}.", parser=Ability.from_name)
    ] = Ability.ACTION_SEQUENCING,
    shaping: Annotated[Shaping, make_flag(panel=_LEARNABLE, metavar="HOW")] = Shaping.PROGRESS,
    records: Annotated[list[Path] | None, make_flag(panel=_LEARNABLE, metavar="PATH")] = None,
    context: Annotated[int | None, make_flag(panel=_LEARNABLE, metavar="TOKENS", min=1)] = None,
    prompt_set: OfSet = "official",
    workers: Workers = None,
    ray: OnRay = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Check a benchmark: its declaration, its tasks, and each line of task files.

    Random walks test the declaration. The command reports goals that hold at the start or name unknown
    objects, plans that do not solve their task, and tasks without a plan. The exit status is 2 if it finds
    any.

    With --against, count tasks that another benchmark gives away. They are equal tasks, tasks with equal
    goals, and tasks that a plan of the other benchmark solves: the plan of its task with the most similar
    goals. With --split, check that eai generate made the set of this name with the secret. The manifest in
    the folder has the secret's digest.

    With --references, also search the shortest plan of each task in task files, and actions that win games of
    the task. Environments then need not search them. If the files are right, missing plans are added to them.

    With --learnable, print whether rewards can teach a model: the rewards of null models, the groups of
    answers with mixed rewards, and the tasks that exceed a context.

    Example: eai check tasks/

    Example: eai check tasks/ --learnable --records runs --context 2048

    Options:
        against: Count tasks that this benchmark gives away, such as training tasks.
        split: Name of a set by eai generate that --secret must prove.
        secret: The secret of the set.
        schema: Print the JSON Schema of a line of a task file instead.
        references: Also search shorter plans, and add missing ones to the task files.
        learnable: Print whether rewards can teach a model, instead of mistakes.
        shaping: Definition of the reward.
        records: Records of a model's run with several answers to each task (--epochs), or folders of them.
        context: Number of tokens of the model's context.
    """
    if learnable:
        reference = _require_benchmark_reference(path)
        print_learnability_of_rewards(
            *(reference, ability, shaping, records or (), context, prompt_set, data, workers, ray),
            as_json=as_json,
        )
    elif schema:
        print(json.dumps(make_task_line_schema(), indent=2))
    elif against is not None:
        _print_task_overlap(against, _require_benchmark_reference(path), data, as_json=as_json)
    elif split is not None:
        if not secret:
            raise InputError("--split: also give --secret, or set EAI_SECRET")
        folder = Path(_require_benchmark_reference(path))
        findings = [
            DataMistake(str(folder / split), problem)
            for problem in find_reasons_to_doubt_published_set(folder, split, secret)
        ]
        print_findings_and_exit(findings, "the set was made with this secret", as_json=as_json)
    elif is_path_of_task_files(_require_benchmark_reference(path)):
        _check_task_files(Path(path), workers, ray, references=references, as_json=as_json)
    elif references:
        raise InputError(f"--references: expected task files, not {path}; eai export tasks writes them")
    else:
        _check_benchmark(path, workers, ray, data, as_json=as_json)


def _require_benchmark_reference(reference: str) -> str:
    if not reference:
        raise InputError(f"expected a benchmark: {REFERENCES}")
    return reference


def _check_task_files(
    path: Path, workers: int | None, ray: str | None, *, references: bool, as_json: bool
) -> None:
    fine = "all tasks are as they say"
    with open_scoring_workers(workers, ray) as pool:
        map_items = partial(_map_and_show_progress, pool, f"checking {path}", as_json)
        find_more_mistakes = partial(_describe_wrong_reference_plans, references)
        findings = list(check_task_files(path, _find_benchmark_domain, find_more_mistakes, map_items))
        if references and not findings:
            map_items = partial(_map_and_show_progress, pool, f"playing {path}", as_json)
            added = sum(_add_reference_plans_to_task_file(file, map_items) for file in find_task_files(path))
            fine += f"; references of {format_count(added, 'task')} added"
    print_findings_and_exit(findings, fine, as_json=as_json)


def _check_benchmark(
    reference: str, workers: int | None, ray: str | None, data: Path | None, *, as_json: bool
) -> None:
    benchmark = find_benchmark(reference)
    with open_data_source(data) as source, open_scoring_workers(workers, ray) as pool:
        number = len(benchmark.tasks(source))
        map_items = partial(_map_and_show_progress, pool, f"checking {benchmark.name}", as_json)
        findings, ends = check_benchmark(benchmark, source, map_items)
    parts = format_count(len(benchmark.domain.operators), "operator"), format_count(number, "task")
    fine = f"{benchmark.name}: {' and '.join(parts)}; nothing is wrong"
    if ends:
        fine += f"; the planner solves {ends[SearchEndReason.SOLVED]} of the {ends.total()} without a plan"
    if ends[SearchEndReason.STATES]:
        fine += f", and gives up {ends[SearchEndReason.STATES]} at its limit"
    print_findings_and_exit(findings, fine, as_json=as_json)


def _find_benchmark_domain(reference: str) -> Domain:
    return find_benchmark(reference).domain


def _describe_wrong_reference_plans(
    searches_shorter_plans: bool, benchmark_reference: str, task: Task
) -> list[str]:
    return list(
        describe_wrong_recorded_plans(
            task, find_benchmark(benchmark_reference), searches_shorter_plans=searches_shorter_plans
        )
    )


def _add_reference_plans_to_task_file(file: Path, map_items: MapItems) -> int:
    """Add reference plans to the tasks of a file that lack them. Return the number of changed lines."""
    lines = [place.content.decode() for place in read_task_file_lines(file)]
    completed = list(map_items(_add_reference_plans_to_task_lines, lines))
    if completed != lines:
        write_task_file(file, completed)
    return sum(new != old for new, old in zip(completed, lines, strict=True))


def _add_reference_plans_to_task_lines(lines: Sequence[str]) -> list[str]:
    return [_add_reference_plans_to_task_line(line) for line in lines]


def _add_reference_plans_to_task_line(text: str) -> str:
    """Return the line of a task in a task file with reference plans added, unless it has them."""
    line = read_task_line(text)
    benchmark = find_benchmark(line.base)
    task = make_task_from_line(line, benchmark.domain)
    completed = add_reference_plans(task, benchmark)
    if completed is task:
        return text
    values = {**json.loads(text, strict=False), **get_recorded_plan_fields(completed)}
    return json.dumps(values, ensure_ascii=False, separators=(",", ":"))


def _map_and_show_progress(
    pool: WorkerPool,
    title: str,
    quiet: bool,
    work: Callable[[Sequence[Any]], Sequence[Any]],
    items: Sequence[Any],
) -> Iterator[Any]:
    with show_scoring_progress(title, len(items), quiet=quiet) as report:
        for number, result in enumerate(pool.map_batches(work, items), 1):
            yield result
            report(number)


def _print_task_overlap(
    known_reference: str, tested_reference: str, data: Path | None, *, as_json: bool
) -> None:
    benchmark, tested = find_benchmark(known_reference), find_benchmark(tested_reference)
    with open_data_source(data) as source:
        tasks = [list(each.tasks(source).values()) for each in (benchmark, tested)]
    overlap = measure_overlap(tasks[1], tasks[0], benchmark.domain)
    counts = "of {tasks} tasks {same} are the same, {same_goals} have the same goals, {solved_by_lookup} are "
    print_result(f"{counts.format_map(overlap)}solved by lookup", value=dict(overlap), as_json=as_json)


def tasks(
    out: Annotated[Path, make_flag(metavar="FILE")],
    domain: Annotated[str, make_flag(help=DOMAIN_HELP)],
    problems: Annotated[list[Path] | None, typer.Argument()] = None,
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write all tasks of a benchmark as a task file, for changes or as an example.

    The plans are the data set's own. With PROBLEMS, problems in BDDL or in PDDL of the exported domain are
    written as tasks instead.

    Example: eai export tasks --domain pddl:domain.pddl,problems --out problems.jsonl

    Options:
        out: FILE.jsonl or FILE.jsonl.gz.
        problems: Problems (*.bddl, *.pddl) or folders of problems, instead of the benchmark's tasks.
    """
    if problems and domain.startswith(f"{PDDL}:"):
        raise InputError(
            f"--domain {domain}: the tasks of this benchmark are the problems that --domain names; leave out "
            "the argument PROBLEMS to export them"
        )
    benchmark = find_benchmark(domain)
    with open_data_source(data) as source:
        chosen: Iterable[Task] = (
            read_problems(find_problem_files(problems), benchmark, source)
            if problems
            else benchmark.tasks(source).values()
        )
    lines = [write_task_line(task, domain, benchmark.domain) for task in chosen]
    write_task_file(out, lines)
    made: Json = {"file": str(out), "tasks": len(lines)}
    print_result(f"{format_count(len(lines), 'task')} written to {out}", value=made, as_json=as_json)
