"""Our speed as a ratio to the reference's for an ability, on the same answers in one run.

Only processor time counts. Each side scores answers to a sample of the tasks: those in given response files,
or made ones, which are the data set's own goals, or its scripts written as subgoals, with seeded changes. The
reference scores one set, since that takes it long; ours several of them, as for several models, in a fresh
process with the tasks loaded. What is compared is answers per CPU second. Exits with status 1 when the limit
is missed.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from eai.abilities.notation.goal_lexicon import write_goals
from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.benchmark.gold_answers import AnswerBook, WrittenAnswer, noisy_answer
from eai.data.dataset import fetch
from eai.households.packs import published_packs
from eai.households.virtualhome.domain import as_meant
from eai.households.virtualhome.notation import ACTIONS, VirtualHomeGoals, VirtualHomeSubgoals
from eai.households.virtualhome.tasks import open_tasks
from eai.logic.ltl import read_formula
from eai.tasks.source import TaskSet
from reference import CACHE, REFERENCE, Response, environment, evaluate, read_responses, write_responses
from reference import Ability as Evaluated

CHILD = Path(__file__).with_name("suite_child.py")
SETS = 9
"""How many sets of answers are made."""

RATE = 0.15
"""The share of the parts of an answer that is changed."""


_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Limit:
    """What must hold for an ability.

    Attributes:
        ability: the ability.
        sample: how many tasks are answered.
        ratio: how many times as fast as the reference ours must be.
    """

    ability: Ability
    sample: int
    ratio: float


@dataclass(frozen=True, slots=True)
class Cost:
    """What scoring in a fresh process cost, in seconds of processor time and bytes."""

    answers: int
    score_cpu_seconds: float
    peak_bytes: int

    @property
    def answers_per_cpu_second(self) -> float:
        """Answers scored in a second of processor time."""
        return self.answers / self.score_cpu_seconds


def open_book(ability: Ability) -> AnswerBook:
    """The answers to be changed, for the tasks that have any."""
    tasks = open_tasks()
    if ability is Ability.GOAL_INTERPRETATION:
        domain, notation = as_meant(), VirtualHomeGoals()
        return TaskSet(
            tasks,
            lambda i: WrittenAnswer(write_goals(tasks[i], domain, notation), notation.join),
            tasks.sha256,
        )
    with_goal = [task_id for task_id, task in tasks.items() if task.temporal_goal is not None]
    join = VirtualHomeSubgoals().join
    return TaskSet(with_goal, lambda i: WrittenAnswer(script(tasks[i]), join), tasks.sha256)


def script(task: Task) -> tuple[str, ...]:
    """The steps of a task's script as subgoals, without those that no subgoal can stand for."""
    words = VirtualHomeSubgoals(ACTIONS)
    known = words.lexicon(task.scene).signature
    return tuple(subgoal for subgoal in words.write(task, task.script) if not read_formula(subgoal, known)[1])


def spread(rows: Sequence[_T], size: int) -> Sequence[_T]:
    """As many rows as asked for, evenly spread over all."""
    return rows[:: max(1, len(rows) // size)][:size]


def made_answers(ability: Ability, size: int) -> list[list[Response]]:
    """Sets of made answers to a sample of the tasks."""
    book = open_book(ability)
    tasks = spread(tuple(book), size)
    return [
        [Response(task, noisy_answer(book, task, RATE, str(seed)).text) for task in tasks]
        for seed in range(SETS)
    ]


def given_answers(paths: Sequence[Path], size: int) -> list[list[Response]]:
    """The answers in some response files to a sample of the tasks that the first one answers."""
    first, *others = map(read_responses, paths)
    chosen = spread(first, size)
    tasks = {response.task_id for response in chosen}
    return [[*chosen], *([response for response in other if response.task_id in tasks] for other in others)]


def score_once(ability: Ability, paths: list[Path]) -> Cost:
    """Score response files in a process of its own."""
    command = [sys.executable, str(CHILD), ability.value, *map(str, paths)]
    child = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
    return Cost(**json.loads(child.stdout.splitlines()[-1]))


def compare(limit: Limit, sets: Sequence[list[Response]], repeats: int, cache: Path) -> bool:
    """Run both sides, the reference on the first set, and print the figures; whether the limit is kept."""
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        paths = [Path(folder) / f"model{number}_outputs.json" for number in range(len(sets))]
        for path, responses in zip(paths, sets, strict=True):
            write_responses(path, responses)
        costs = [score_once(limit.ability, paths) for _ in range(repeats)]
        theirs = evaluate(environment(cache), Evaluated(limit.ability.value), sets[0])
        costs += [score_once(limit.ability, paths) for _ in range(repeats)]
    ours = sorted(costs, key=lambda cost: cost.score_cpu_seconds)[len(costs) // 2]
    ratio = ours.answers_per_cpu_second / theirs.tasks_per_cpu_second
    print(f"{limit.ability.value}, {len(sets[0])} tasks, {REFERENCE}, Python {theirs.python}")
    print(
        f"reference  {theirs.tasks_per_cpu_second:9.2f} answers per CPU s   {theirs.cpu_seconds:7.2f} CPU s"
    )
    print(
        f"eai        {ours.answers_per_cpu_second:9.2f} answers per CPU s   "
        f"{ours.score_cpu_seconds:7.3f} CPU s for {len(sets)} sets, peak {ours.peak_bytes / 1e6:.0f} MB"
    )
    kept = ratio >= limit.ratio
    print(f"{'kept  ' if kept else 'MISSED'}  ratio {ratio:,.0f}, at least {limit.ratio:,.0f}")
    return kept


def main(limit: Limit, description: str) -> int:
    """The command line of one ability's benchmark."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--sample", type=int, default=limit.sample, help="how many tasks are answered")
    parser.add_argument(
        "--repeats", type=int, default=3, help="runs of ours before and after the reference's"
    )
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    parser.add_argument(
        "--responses",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="response files of one or more models to be scored instead of made answers",
    )
    arguments = parser.parse_args()
    fetch(packs=published_packs())
    sets = (
        given_answers(arguments.responses, arguments.sample)
        if arguments.responses
        else made_answers(limit.ability, arguments.sample)
    )
    return 0 if compare(limit, sets, arguments.repeats, arguments.cache) else 1
