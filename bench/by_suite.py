"""Measure answers per CPU second in each of the eight suites.

The answers are the public ones in ``../shared/oracle``. A fresh process scores them in three rounds:

- cold: the answers of the first model; this round makes all tasks and scorers;
- steady: the answers of the other models; cached results help only if two models give equal answers;
- again: the answers of the other models a second time, as a trainer's samples repeat.

The median of several processes counts. Garbage collection is as rare as in ``eai score``. Bytecode must be
there, as in an installed package: the cold round takes half as long again without it
(``PYTHONDONTWRITEBYTECODE``). No planner runs. With `--reference`, the reference package scores some of the
first model's answers in the same run, evenly spread over the tasks, for suites that it can score here.

    python -m bench by_suite [--suite behavior/] [--repeats 3] [--protocol strict] [--reference 100]
    python -m bench by_suite --beside ../before/.venv/bin/python

The second command also measures the build that the other interpreter imports, in turn with this one. It
prints how many times as fast this build is: the median of the ratios of consecutive runs, because the speed
of a machine varies.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

from bench.record import add_write_option, get_suite_title, write_rows
from bench.result import Figure
from differential import reference
from differential.oracle_answers import ORACLE, oracle_answers, require_oracle
from eai.abilities.protocol import PAPER_ABILITIES, Ability, Protocol
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.collector import reduce_garbage_collection
from eai.tasks.source import Source

ROOT = Path(__file__).resolve().parents[1]
MODELS = ("gpt-4o-2024-05-13", "claude-3-5-sonnet-20240620", "llama-3-8b-chat", "mixtral-8x22b-instruct-v0.1")


class Speed(NamedTuple):
    """Answers scored per CPU second in the rounds cold, steady and again."""

    cold: float
    steady: float
    again: float


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--protocol", type=Protocol, default=Protocol.STRICT)
    parser.add_argument("--reference", type=int, metavar="N", help="so many answers by the reference, too")
    parser.add_argument("--beside", help="an interpreter that imports another build")
    parser.add_argument("--once", action="store_true", help=argparse.SUPPRESS)
    add_write_option(parser)
    arguments, rows = parser.parse_args(), []
    require_oracle()
    suites = [
        (d, a) for d in PAPER_BENCHMARKS for a in PAPER_ABILITIES if arguments.suite in f"{d}/{a.value}"
    ]
    if arguments.once:
        print(
            json.dumps(
                [measure_this_process(domain, ability, arguments.protocol) for domain, ability in suites]
            )
        )
        return
    builds = [sys.executable, *([arguments.beside] if arguments.beside else [])]
    print(f"{'answers a CPU second':34}" + f"{'cold':>8}{'steady':>8}{'again':>8}" * len(builds))
    for domain, ability in suites:
        name = f"{domain}/{ability.value}"
        runs = [
            [_measure_fresh_process(build, name, arguments.protocol) for build in builds]
            for _ in range(arguments.repeats)
        ]
        speeds = [_compute_medians(of_build) for of_build in zip(*runs, strict=True)]
        told = "".join(f"{figure:8,.0f}" for speed in speeds for figure in speed)
        if len(builds) > 1:
            ratios = [Speed(*(b / a for a, b in zip(*run, strict=True))) for run in runs]
            told += "   times " + ", ".join(f"{ratio:.2f}" for ratio in _compute_medians(ratios))
        print(f"{name:34}{told}", flush=True)
        rows.append([get_suite_title(domain, ability.value), *_make_cells(speeds[0])])
        if arguments.reference and domain == "virtualhome":
            speed_there = measure_reference_speed(ability, arguments.reference)
            print(f"    {reference.REFERENCE:30}{speed_there:8.1f}", flush=True)
    if arguments.write:
        write_rows("by_suite", rows)


def _make_cells(speed: Speed) -> list[Figure]:
    """Return the speeds, and the cost of 100 million answers at the steady speed."""
    hours = 1e8 / speed.steady / 3600
    on_node = f"{hours / 64:.1f} h" if hours > 64 else f"{60 * hours / 64:.1f} min"
    return [*map(round, speed), float(f"{hours:.2g}"), on_node, f"${0.05 * hours:.2f}"]


def _compute_medians(speeds: Sequence[Speed]) -> Speed:
    return Speed(*map(median, zip(*speeds, strict=True)))


def _measure_fresh_process(python: str, suite: str, protocol: Protocol) -> Speed:
    """Measure the speed of a fresh process of an interpreter."""
    program = [python, "-m", "bench", "by_suite"]
    command = [*program, "--once", "--suite", suite, "--protocol", protocol.value]
    (speed,) = json.loads(
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    )
    return Speed(*speed)


def measure_this_process(domain: str, ability: Ability, protocol: Protocol) -> Speed:
    """Measure the speed of this process, which must not have scored anything yet."""
    suite = open_suite(domain, ability, protocol, source=Source(planner=PlannerChoice.NONE))
    first, *others = [_read_answers(domain, ability, model) for model in MODELS]
    reduce_garbage_collection()
    return Speed(_measure_speed(suite, [first]), _measure_speed(suite, others), _measure_speed(suite, others))


def measure_reference_speed(ability: Ability, number: int) -> float:
    """Return how many answers the reference package scores per CPU second, without its start-up."""
    answers = _read_answers("virtualhome", ability, MODELS[0])
    some = answers[:: max(1, len(answers) // number)][:number]
    measurement = reference.evaluate(
        reference.environment(),
        reference.Ability(ability.value),
        [reference.Response(task_id, text) for task_id, text in some],
    )
    return measurement.tasks_per_cpu_second


def _measure_speed(suite: Suite, files: Sequence[Sequence[tuple[str, str]]]) -> float:
    start = time.process_time()
    for answers in files:
        together = suite.choose_suite_for_answers([text for _, text in answers])
        for task_id, text in answers:
            together.score(task_id, text)
    return sum(map(len, files)) / (time.process_time() - start)


def _read_answers(domain: str, ability: Ability, model: str) -> list[tuple[str, str]]:
    path = ORACLE / domain / ability.value / f"{model}.json.gz"
    return [(answer.task_id, answer.text) for answer in oracle_answers(path)]
