"""Answers a CPU second in every suite: one model's answers, then those of three others, each answer once.

The answers are those of ``../shared/oracle``, as released. A fresh process scores those of the first model,
which makes all tasks and scorers (cold), then those of the others (steady); the median of several processes
counts. What is remembered of an answer helps only where another model gives the same. Garbage is searched for
as seldom as in ``eai score``. No planner is asked. In the same run the reference package may score some of
the first model's answers, evenly spread over the tasks, where it can do so here (`reference`).

    python bench/by_suite.py [--suite behavior/] [--repeats 3] [--protocol strict] [--reference 100]
"""

from __future__ import annotations

import argparse
import gzip
import json
import multiprocessing
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

import reference
from eai.abilities.protocol import Ability, Protocol
from eai.benchmarks.source import Source
from eai.benchmarks.suite import Suite, available_suites, open_suite
from eai.pddl.planning import PlannerChoice
from eai.scoring.undisturbed import undisturbed

ORACLE = Path(__file__).resolve().parents[2] / "shared" / "oracle"
MODELS = ("gpt-4o-2024-05-13", "claude-3-5-sonnet-20240620", "llama-3-8b-chat", "mixtral-8x22b-instruct-v0.1")


class Speed(NamedTuple):
    """How many answers were scored a CPU second: those of the first model, and those of the others."""

    cold: float
    steady: float


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--suite", default="", help="a part of DOMAIN/ABILITY")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--protocol", type=Protocol, default=Protocol.STRICT)
    parser.add_argument("--reference", type=int, metavar="N", help="so many answers by the reference, too")
    arguments = parser.parse_args()
    if not ORACLE.is_dir():
        sys.exit("the oracle is not beside the repository")
    print(f"{'answers a CPU second':42} {'cold':>8} {'steady':>8}")
    for domain, ability in available_suites():
        name = f"{domain}/{ability.value}"
        if arguments.suite in name:
            asked = [(domain, ability, arguments.protocol)] * arguments.repeats
            with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as fresh:
                speeds = fresh.starmap(measured, asked, chunksize=1)
            cold, steady = (median(each) for each in zip(*speeds, strict=True))
            print(f"{name:42} {cold:8,.0f} {steady:8,.0f}", flush=True)
            if arguments.reference and domain == "virtualhome":
                told = reference_speed(ability, arguments.reference)
                print(f"    {reference.REFERENCE:38} {told:8.1f}", flush=True)


def measured(domain: str, ability: Ability, protocol: Protocol) -> Speed:
    """The speed of this process, which has scored nothing yet."""
    suite = open_suite(domain, ability, protocol, source=Source(planner=PlannerChoice.NONE))
    first, *others = [_answers(domain, ability, model) for model in MODELS]
    with undisturbed():
        return Speed(_speed(suite, [first]), _speed(suite, others))


def reference_speed(ability: Ability, number: int) -> float:
    """How many of the first model's answers the reference scores a CPU second, its start not counted."""
    answers = _answers("virtualhome", ability, MODELS[0])
    some = answers[:: max(1, len(answers) // number)][:number]
    measurement = reference.evaluate(
        reference.environment(),
        reference.Ability(ability.value),
        [reference.Response(task_id, text) for task_id, text in some],
    )
    return measurement.tasks_per_cpu_second


def _speed(suite: Suite, files: Sequence[Sequence[tuple[str, str]]]) -> float:
    start = time.process_time()
    for answers in files:
        together = suite.over([text for _, text in answers])
        for task_id, text in answers:
            together.score(task_id, text)
    return sum(map(len, files)) / (time.process_time() - start)


def _answers(domain: str, ability: Ability, model: str) -> list[tuple[str, str]]:
    content = json.loads(gzip.decompress((ORACLE / domain / ability.value / f"{model}.json.gz").read_bytes()))
    rows = content.get("tasks") or content.get("records")
    return [
        (row.get("id", row.get("identifier")).split("@")[0], row.get("llm_output", row.get("response")) or "")
        for row in rows
    ]


if __name__ == "__main__":
    main()
