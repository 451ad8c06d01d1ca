"""``eai tasks``: task files, checked and written."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from eai.abilities.task import Task
from eai.abilities.verdict import Json
from eai.benchmark.registry import PDDL, find_benchmark
from eai.cli.console import DOMAIN_HELP, counted, data_progress, tell, tell_findings
from eai.cli.options import AsJson
from eai.cli.store import DataFolder, store
from eai.errors import InputError
from eai.generator.problem_files import ProblemReader, problem_files_in
from eai.generator.sets import unproven
from eai.generator.splits import Overlap
from eai.tasks.source import Finding, Source
from eai.tasks.task_files import check_task_files, write_task_file
from eai.tasks.task_lines import json_schema, written
from eai.world.domain import Domain

app = typer.Typer(help="Task files: check and write them, print their schema.", no_args_is_help=True)


@app.command()
def check(
    path: Annotated[Path, typer.Argument(help="A task file, or a folder of them.", metavar="PATH")],
    as_json: AsJson = False,
) -> None:
    """Name every line that is no task and every plan that does not solve its; exit status 2 if there is one.

    Example: eai tasks check tasks/
    """
    findings = list(check_task_files(path, lambda base: find_benchmark(base).domain))
    tell_findings(findings, "all tasks are as they say", as_json=as_json)


@app.command("import")
def import_problems(
    files: Annotated[
        list[Path], typer.Argument(help="Problems, *.bddl or *.pddl, or folders of them.", metavar="FILE")
    ],
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="The file to write: FILE.jsonl or FILE.jsonl.gz.")
    ],
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write problems in BDDL, or in PDDL of the exported domain, as tasks of a benchmark.

    Example: eai tasks import problems --domain lamps:lamps --out tasks.jsonl
    """
    if domain.startswith(f"{PDDL}:"):
        raise InputError(
            f"--domain {domain}: its problems are tasks already; eai tasks write --domain writes them"
        )
    with data_progress() as report:
        benchmark = find_benchmark(domain)
        tasks = ProblemReader(benchmark, Source(store(data), report)).read(problem_files_in(files))
    _write(out, tasks, domain, benchmark.domain, as_json=as_json)


@app.command()
def write(
    domain: Annotated[str, typer.Option(help=DOMAIN_HELP)],
    out: Annotated[
        Path, typer.Option(metavar="FILE", help="The file to write: FILE.jsonl or FILE.jsonl.gz.")
    ],
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Write all tasks of a benchmark as a task file, to be changed, or as an example.

    The plans are the data set's own.

    Example: eai tasks write --domain pddl:domain.pddl,problems --out problems.jsonl
    """
    with data_progress() as report:
        benchmark = find_benchmark(domain)
        tasks = benchmark.tasks(Source(store(data), report))
    _write(out, tasks.values(), domain, benchmark.domain, as_json=as_json)


def _write(out: Path, tasks: Iterable[Task], base: str, domain: Domain, *, as_json: bool) -> None:
    lines = [written(task, base, domain) for task in tasks]
    write_task_file(out, lines)
    made: Json = {"file": str(out), "tasks": len(lines)}
    tell(f"{counted(len(lines), 'task')} written to {out}", value=made, as_json=as_json)


@app.command()
def reveal(
    folder: Annotated[Path, typer.Argument(help="A folder that eai generate wrote.", metavar="FOLDER")],
    split: Annotated[str, typer.Option(help="The name of the set.")],
    secret: Annotated[str, typer.Option(envvar="EAI_SECRET", help="What it was made with.")],
    as_json: AsJson = False,
) -> None:
    """Check that a set was made with the secret whose digest was published; exit status 2 if it was not.

    Example: eai tasks reveal fresh/ --split test --secret "what we kept"
    """
    findings = [Finding(str(folder / split), problem) for problem in unproven(folder, split, secret)]
    tell_findings(findings, "the set was made with this secret", as_json=as_json)


@app.command()
def overlap(
    known: Annotated[str, typer.Argument(help=f"Say, what was trained on. {DOMAIN_HELP}", metavar="A")],
    asked: Annotated[str, typer.Argument(help="Say, what is tested with.", metavar="B")],
    as_json: AsJson = False,
    data: DataFolder = None,
) -> None:
    """Count the tasks of B that A gives away: the same, of the same goals, solved by A's plans (eai/lookup).

    Example: eai tasks overlap tasks/train.jsonl tasks/test.jsonl
    """
    with data_progress() as report:
        source = Source(store(data), report)
        benchmark, tested = find_benchmark(known), find_benchmark(asked)
        tasks = [list(each.tasks(source).values()) for each in (benchmark, tested)]
    found = Overlap.of(tasks[1], tasks[0], benchmark.domain)
    said = f"of {found.tasks} tasks {found.same} are the same, {found.same_goals} have the same goals, "
    tell(f"{said}{found.solved_by_lookup} are solved by lookup", value=asdict(found), as_json=as_json)


@app.command()
def schema() -> None:
    """Print the JSON Schema of a line of a task file.

    Example: eai tasks schema > task.schema.json
    """
    print(json.dumps(json_schema(), indent=2))
