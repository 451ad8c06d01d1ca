"""Measure how often simple shortcuts are right in generated pairs of tasks.

    python -m bench pairs FOLDER [--planned N]

A shortcut guesses whether a task is solvable or clear without solving it. The shortcuts are: refuse all tasks
or none; the length of the task's part of a prompt; the task's id; the category of the object that lacks
something or is meant. The last three are fitted on every other pair and tested on the rest. For each shortcut
the program prints the share of tasks that it guesses right. A shortcut with perfect plans has this share of
success. For ambiguous tasks it also prints how often the intended object is listed before the other one.

With `--planned` the planner looks for a plan of the first N tasks without a plan, in 3,000 states.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from bench.record import add_write_option, write_rows
from eai.abilities.protocol import Ability
from eai.abilities.task_features import TaskFeatures
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.registry import find_benchmark
from eai.planning.planner import Planner
from eai.planning.search import Limits
from eai.tasks.planning import find_plan
from eai.tasks.source import Source
from eai.tasks.special import AmbiguousTaskMark, PossiblyImpossibleTaskMark
from eai.tasks.task import Task
from eai.tasks.task_files import read_task_file_lines
from eai.tasks.task_lines import read_task_line

LIMITS = Limits(3000)


def main() -> None:
    """Print how often each shortcut is right."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--planned", type=int, default=0)
    add_write_option(parser)
    arguments = parser.parse_args()
    benchmark = find_benchmark(str(arguments.folder))
    tasks = list(benchmark.tasks(Source()).values())
    about = {
        line.id: line.about
        for line in (read_task_line(each.content) for each in read_task_file_lines(arguments.folder))
    }
    shortcuts: dict[str, Callable[[Task], object]] = {
        "all or none": lambda task: 0,
        "length": lambda task: len(_describe_in_prompt(task, benchmark)) // 50,
        "id": lambda task: task.id[-1],
        "kind": lambda task: _find_missing_kind(task, about[task.id]),
    }
    right = {name: _count_right(tasks, feature) for name, feature in shortcuts.items()}
    for name, number in right.items():
        print(f"{name}: {number} of {len(tasks)}")
    if arguments.write:
        write_rows("hazards", [[arguments.folder.name, len(tasks), *right.values()]])
    listed = [
        task.scene.index[special.fits[0]] < task.scene.index[special.fits[1]]
        for task in tasks
        if isinstance(special := task.special, AmbiguousTaskMark) and len(special.fits) > 1
    ]
    if listed:
        print(f"meant is listed first: {sum(listed)} of {len(listed)}")
    planner, impossible = Planner(benchmark.domain), [task for task in tasks if task.has_no_plan]
    chosen = impossible[: arguments.planned]
    found = sum(bool(find_plan(task, planner, LIMITS).plan) for task in chosen)
    print(f"the planner finds plans of {found} of {len(chosen)} tasks without one")


def _describe_in_prompt(task: Task, benchmark: Benchmark) -> str:
    """Return the part of a prompt that describes the task."""
    wording = benchmark.wording(Ability.ACTION_SEQUENCING)
    return "".join(
        (wording.describe_objects(task), wording.describe_initial_state(task), wording.describe_goals(task))
    )


def _find_missing_kind(task: Task, about: Mapping[str, object]) -> tuple[str, str]:
    """Return the predicate and object category of the missing fact, or of the instruction's fact."""
    match task.special:
        case PossiblyImpossibleTaskMark(missing) if missing:
            fact = missing[0]
        case AmbiguousTaskMark(fits):
            fact = f"({fits[0]})"
        case _:
            fact = str(about["lacks"])
    predicate, _, name = fact.removesuffix(")").partition("(")
    return predicate, task.scene.objects[task.scene.index[name]].category


def _count_right(tasks: Sequence[Task], feature: Callable[[Task], object]) -> int:
    """Count the tasks on which a shortcut is right.

    It guesses the majority label that the other pairs' tasks with this feature have.
    """
    titles = {title: number % 2 for number, title in enumerate(dict.fromkeys(task.title for task in tasks))}
    right = 0
    for half in (0, 1):
        votes = Counter[object]()
        for task in tasks:
            if titles[task.title] != half:
                votes[feature(task)] += 1 if TaskFeatures.from_task(task).is_declining_correct else -1
        tried = [task for task in tasks if titles[task.title] == half]
        right += sum(
            (votes[feature(task)] > 0) == TaskFeatures.from_task(task).is_declining_correct for task in tried
        )
    return right
