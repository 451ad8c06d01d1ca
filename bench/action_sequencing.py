"""Measure the speed of VirtualHome action sequencing as a ratio to the reference package's, on 342 answers.

`make bench` runs it. Only processor time counts. The time of the reference package is its evaluation without
start-up. Our time is scoring every answer once in a fresh process, without imports and loading, which have
their own limit. The exit status is 1 if a limit is missed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench import answers
from bench.record import add_write_option, write_figures
from differential.reference import (
    CACHE,
    REFERENCE,
    Ability,
    Measurement,
    Response,
    environment,
    evaluate,
    package_folder,
    write_responses,
)
from eai.benchmarks.packs import fetch_packs, find_packs
from eai.benchmarks.registry import list_paper_benchmarks

ROOT = Path(__file__).resolve().parents[1]
CHILD = Path(__file__).with_name("scoring_child.py")
RATIO = 3_000.0
STARTUP_CPU_SECONDS = 0.5
PEAK_BYTES = 150_000_000


@dataclass(frozen=True, slots=True)
class Cost:
    """Cost of scoring a response file once in a fresh process, in seconds of processor time and bytes.

    Attributes:
        executable: Whether the plan of each task can be executed, by task id; None for an excluded task.
    """

    import_cpu_seconds: float
    load_cpu_seconds: float
    score_cpu_seconds: float
    peak_bytes: int
    executable: dict[str, bool | None]

    @property
    def startup_cpu_seconds(self) -> float:
        """Processor seconds of importing the package and loading the data."""
        return self.import_cpu_seconds + self.load_cpu_seconds

    @property
    def tasks_per_cpu_second(self) -> float:
        """Answers scored per second of processor time."""
        return len(self.executable) / self.score_cpu_seconds


def score_once(path: Path) -> Cost:
    """Score a response file in a fresh process, and return its cost."""
    child = subprocess.run(
        [sys.executable, str(CHILD), str(path)],
        check=True,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT / "tests")},
    )
    return Cost(**json.loads(child.stdout.splitlines()[-1]))


def choose_median_cost(costs: list[Cost]) -> Cost:
    """Return the run with the median scoring time."""
    return sorted(costs, key=lambda cost: cost.score_cpu_seconds)[len(costs) // 2]


def measure(python: Path, responses: list[Response], repeats: int) -> tuple[Cost, Measurement]:
    """Measure the reference package and `eai` on the same answers.

    `eai` is measured before and after the reference package, because the other load of a machine varies.
    """
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        path = Path(folder) / "answers.json"
        write_responses(path, responses)
        before = [score_once(path) for _ in range(repeats)]
        theirs = evaluate(python, Ability.ACTION_SEQUENCING, responses)
        after = [score_once(path) for _ in range(repeats)]
    return choose_median_cost(before + after), theirs


def count_agreements(ours: Cost, theirs: Measurement) -> str:
    """Return on how many answers both packages agree whether the plan can be executed, as in "340 of 342"."""
    _, rows = theirs.results
    same = sum(ours.executable[task_id] == row["executable"] for task_id, row in rows.items())
    return f"{same} of {len(rows)}"


def report(ours: Cost, theirs: Measurement, *, write: bool) -> bool:
    """Print the figures, and return whether all limits are kept."""
    ratio = ours.tasks_per_cpu_second / theirs.tasks_per_cpu_second
    limits = (
        (f"ratio {ratio:,.0f}, at least {RATIO:,.0f}", ratio >= RATIO),
        (
            f"import and load {ours.startup_cpu_seconds:.2f} CPU s, at most {STARTUP_CPU_SECONDS}",
            ours.startup_cpu_seconds <= STARTUP_CPU_SECONDS,
        ),
        (
            f"peak {ours.peak_bytes / 1e6:.0f} MB, at most {PEAK_BYTES / 1e6:.0f}",
            ours.peak_bytes <= PEAK_BYTES,
        ),
    )
    print(f"{len(ours.executable)} answers, {REFERENCE}, Python {theirs.python}")
    print(
        f"reference  {theirs.tasks_per_cpu_second:9.2f} tasks per CPU s   {theirs.cpu_seconds:7.2f} CPU s, "
        f"start-up {theirs.startup_cpu_seconds:.2f} CPU s, peak {theirs.peak_bytes / 1e6:.0f} MB"
    )
    print(
        f"eai        {ours.tasks_per_cpu_second:9.2f} tasks per CPU s   {ours.score_cpu_seconds:7.3f} CPU s, "
        f"import {ours.import_cpu_seconds:.2f} CPU s, load {ours.load_cpu_seconds:.2f} CPU s"
    )
    print(f"agreement on executability: {count_agreements(ours, theirs)} answers that the reference lists")
    for text, kept in limits:
        print(f"{'kept  ' if kept else 'MISSED'}  {text}")
    if write:
        write_figures("action_sequencing", {"Times as fast as the reference, on 342 answers": round(ratio)})
    return all(kept for _, kept in limits)


def main() -> int:
    """Measure both packages and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--limit", type=int, help="the first N answers only (a quick look: the ratio varies with them)"
    )
    parser.add_argument(
        "--repeats", type=int, default=5, help="runs of ours before and after the reference's"
    )
    parser.add_argument("--cache", type=Path, default=CACHE, help="where the reference's environment is kept")
    add_write_option(parser)
    arguments = parser.parse_args()
    fetch_packs(packs=find_packs(list_paper_benchmarks()))
    python = environment(arguments.cache)
    responses = answers.make_responses(package_folder(python))[: arguments.limit]
    costs = measure(python, responses, arguments.repeats)
    return 0 if report(*costs, write=arguments.write) else 1
