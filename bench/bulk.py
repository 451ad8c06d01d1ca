"""Measure bulk scoring and single rewards of VirtualHome's plans.

For ``eai score``, the processor time of the whole command counts, with imports and making the tasks. Beside
it stands the time of scoring alone in the same run, with garbage collection as rare as in the command.
Modules are compiled to bytecode beforehand, like modules of an installed package. The answers are the data
set's scripts with seeded noise, or given response files. They are repeated as often as asked, each time under
another model name.

With ``--search`` only rewards that search are measured, in both households: subgoals by `progress`, and
plans by `repair`. A batch is 512 gold answers with noise, eight to each of 64 tasks.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from statistics import quantiles

from bench.record import add_write_option, write_figures
from eai.abilities.protocol import Ability
from eai.benchmarks.gold_answers import make_noisy_answer, open_gold_answers
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import Suite, open_suite
from eai.results.batch import Scoring
from eai.results.collector import reduce_garbage_collection
from eai.results.responses import find_response_files, read_responses
from eai.results.reward import Reward

CLI = "from eai.cli import main; main()"
NAMED = ("--domain", "virtualhome", "--ability", "action_sequencing")
BATCH = 512
_TASKS = 64
"""Number of tasks in a batch of rewards that search."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--responses", type=Path, help="a response file, or a folder of them")
    parser.add_argument("--search", action="store_true", help="measure only rewards that search")
    parser.add_argument("--copies", type=int, default=10, help="how often the answers are scored")
    add_write_option(parser)
    arguments = parser.parse_args()
    if arguments.search:
        _measure_rewards_that_search()
        return
    suite = open_suite("virtualhome", Ability.ACTION_SEQUENCING)
    answers = (
        _make_noisy_answers(suite)
        if arguments.responses is None
        else _read_given_answers(suite, arguments.responses)
    )
    speeds: list[int] = []
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        for copy in range(arguments.copies):
            for model, rows in enumerate(answers):
                written = [{"identifier": task_id, "llm_output": text} for task_id, text in rows]
                (place / f"model-{copy}-{model}_outputs.json").write_text(json.dumps(written))
        number = arguments.copies * sum(map(len, answers))
        print(f"eai score, {number:,} answers, records written: answers per CPU s")
        _measure_command(place, ["score", str(next(place.iterdir())), *NAMED])  # leaves the bytecode
        for option in ("--no-explanations", "--explanations"):
            seconds, memory = _measure_command(
                place, ["score", folder, *NAMED, option, "--out", str(place / "out")]
            )
            speeds.append(round(number / seconds))
            print(f"  {option:18} {number / seconds:8,.0f}   {memory:5.0f} MB at most")
    together = [answer for rows in answers for answer in rows]
    reduce_garbage_collection()
    for name in ("the first time", "steady"):
        seconds = _measure_seconds(lambda: [suite.score(*answer) for answer in together])
        speeds.append(round(len(together) / seconds))
        print(f"  scoring alone, {name:15} {len(together) / seconds:8,.0f}")
    reward, batch = _measure_rewards(suite, together)
    if arguments.write:
        write_figures(
            "bulk",
            {
                "Answers per CPU second with records, without explanations": speeds[0],
                "Scoring alone: first time, afterwards": f"{speeds[2]:,}, {speeds[3]:,}",
                "CPU ms per reward: median, 99th percentile": reward,
                "Warm batch of 512 answers: one process, two workers": batch,
            },
        )


def _make_noisy_answers(suite: Suite) -> list[list[tuple[str, str]]]:
    book = open_gold_answers(suite.benchmark, suite.ability)
    return [
        [(task_id, make_noisy_answer(book, task_id, 0.2, f"{seed}").text) for task_id in suite.task_ids]
        for seed in range(9)
    ]


def _measure_rewards_that_search() -> None:
    """Print the CPU seconds of a batch of new answers, and of the part that is needed once a task."""
    reduce_garbage_collection()
    rewards = ((Ability.SUBGOAL_DECOMPOSITION, "progress"), (Ability.ACTION_SEQUENCING, "repair"))
    for household, (ability, shaping) in product(PAPER_BENCHMARKS, rewards):
        suite = open_suite(household, ability)
        book, reward = open_gold_answers(suite.benchmark, ability), Reward(suite, shaping)
        answers = [
            (task_id, make_noisy_answer(book, task_id, 0.2, f"{seed}").text)
            for task_id in suite.task_ids[:_TASKS]
            for seed in range(BATCH // _TASKS)
        ]
        first = _measure_seconds(lambda: [reward(*answer) for answer in answers[:: BATCH // _TASKS]])  # noqa: B023
        rest = _measure_seconds(lambda: [reward(*answer) for answer in answers])  # noqa: B023
        print(f"{suite.domain} {ability.value} {shaping}: {len(answers)} answers {first + rest:.1f} CPU s,")
        print(f"  the first answer to each of {_TASKS} tasks {first:.1f} CPU s")


def _read_given_answers(suite: Suite, path: Path) -> list[list[tuple[str, str]]]:
    files = [
        read_responses(file, suite.task_ids, suite.benchmark.data.task_id_of)
        for file in find_response_files(path)
    ]
    return [[(response.task_id, response.text) for response in file.responses] for file in files]


def _measure_command(folder: Path, arguments: Sequence[str]) -> tuple[float, float]:
    """Return the CPU seconds of a command with its processes, and the peak memory of the largest one in MB.

    Args:
        folder: Folder of its bytecode.
        arguments: Arguments of the command.
    """
    written = {"PYTHONPYCACHEPREFIX": str(folder / "bytecode"), "PYTHONDONTWRITEBYTECODE": ""}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-c", CLI, *arguments],
        check=True,
        stdout=subprocess.DEVNULL,
        env={**os.environ, **written},
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used, after.ru_maxrss / 1024


def _measure_rewards(suite: Suite, answers: Sequence[tuple[str, str]]) -> tuple[str, str]:
    """Print and return the milliseconds of a reward, and of a batch of rewards."""
    reward = Reward(suite, "progress")
    for answer in answers:  # all scorers are made
        reward(*answer)
    single = [1e6 * _measure_seconds(partial(reward, *answer)) for answer in answers]
    cuts = quantiles(single, n=100)
    print(f"one reward: {cuts[49]:.0f} microseconds in the median, {cuts[98]:.0f} at the 99th percentile")
    batch = answers[:BATCH]
    here = min(
        _measure_seconds(lambda: reward.batch(*zip(*batch, strict=True)), time.perf_counter) for _ in range(5)
    )
    with Scoring(workers=2) as scoring:
        for _ in range(5):  # by now both workers have made the scorers of all tasks
            list(scoring.compute_rewards(reward, answers))
        there = min(
            _measure_seconds(lambda: list(scoring.compute_rewards(reward, batch)), time.perf_counter)
            for _ in range(9)
        )
    print(f"a warm batch of {BATCH}: {1e3 * here:.0f} ms here, {1e3 * there:.0f} ms with two workers (wall)")
    return f"{cuts[49] / 1e3:.2f}, {cuts[98] / 1e3:.2f}", f"{1e3 * here:.0f}, {1e3 * there:.0f} ms"


def _measure_seconds(call: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    start = clock()
    call()
    return clock() - start
