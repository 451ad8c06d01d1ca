"""Run trials of exported task folders with users of this machine instead of containers.

    python -m bench harbor [--sample 20] [--domain virtualhome ...] [--ability acting ...]

It needs root and Linux: each service is a process of its own user, with the machine's files as its image.
With EAI_HARBOR, Harbor also checks the folders, as in ``pytest tests/harbor``. Harbor needs Python 3.12:

    python3.13 -m venv harbor && harbor/bin/pip install harbor
    EAI_HARBOR=$PWD/harbor/bin/harbor python -m bench harbor
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from bench.record import add_write_option, write_rows
from bench.result import Figure
from boxes import lacking
from eai.base.store import DataPackStore
from eai.benchmarks.registry import PAPER_BENCHMARKS
from eai.extensions.harbor.folders import IMAGE, write_task_folders
from extensions.harbor.trials import HARBOR, Trial, asked, lint


def measure_trial_rewards(folder: Path, place: Path) -> tuple[float, float]:
    """Return the reward of an untouched trial, and the reward after the solution."""
    with Trial(folder, place, DataPackStore()) as trial:
        idle = trial.judge()["reward"]
        trial.solve()
        return idle, trial.judge()["reward"]


def measure_suite(domain: str, ability: str, sample: int, place: Path) -> list[Figure]:
    """Run trials of sampled tasks, print the outcomes, and return their number and both sums of rewards."""
    start = time.perf_counter()
    suite, prompts = asked(domain, ability)
    chosen = dict(list(prompts.items())[:: max(1, len(prompts) // sample)])
    written, left_out = write_task_folders(suite, chosen, place / "out")
    folders = [path for path in (place / "out").iterdir() if path.name != IMAGE]
    size = sum(file.stat().st_size for path in folders for file in path.rglob("*") if file.is_file())
    print(f"{domain} {ability}: {written} folders of {size // written:,} bytes, {left_out.total()} left out")
    found = [measure_trial_rewards(path, place / path.name) for path in folders]
    idle, right = map(sum, zip(*found, strict=True))
    print(f"    reward of doing nothing {idle:g}, of the solution {right:g}")
    if HARBOR is not None:
        print(f"    findings of Harbor's check: {sum(len(lint(path)) for path in folders)}")
    print(f"    {time.perf_counter() - start:.0f} s", flush=True)
    return [len(folders), idle, right]


def main() -> None:
    """Run trials in each suite and print a line for each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sample", type=int, default=20, help="tasks of each suite")
    parser.add_argument("--domain", nargs="+", default=list(PAPER_BENCHMARKS))
    parser.add_argument("--ability", nargs="+", default=["acting"])
    add_write_option(parser)
    arguments, rows = parser.parse_args(), list[list[Figure]]()
    why_not = lacking()
    if why_not is not None:
        raise SystemExit(f"cannot isolate processes on this machine: {why_not}")
    for domain in arguments.domain:
        for ability in arguments.ability:
            with tempfile.TemporaryDirectory() as place:
                counts = measure_suite(domain, ability, arguments.sample, Path(place))
                rows.append([f"{domain} {ability}", *counts])
    if arguments.write:
        write_rows("harbor", rows)
