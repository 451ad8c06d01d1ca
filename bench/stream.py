"""A stream of answers to VirtualHome's plans, alone and with workers: processor time, memory, equality.

The answers are mutated plans (`mutated_plans`), as many to each task and all different. They are made and
written first, which is not counted. Then a fresh process reads them one by one and writes a record for each,
and another one does the same with workers. The processor time is that of all processes, starts and ends
included; the memory is the most that the parent had. Of Ray, whose processes are not waited for, it is that
of all that are alive at the end, its services included. Only on Linux.

    python bench/stream.py [--answers 100000] [--workers 2] [--seed 0] [--ray]
"""

from __future__ import annotations

import argparse
import ctypes
import hashlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import cycle, islice
from pathlib import Path
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.abilities.responses import Response
from eai.benchmark.suite import open_suite
from eai.scoring.batch import Scoring
from eai.scoring.collector import collecting_seldom
from eai.scoring.records import write_records
from mutated_answers import maker
from mutations import Dice

SUITE = ("virtualhome", Ability.ACTION_SEQUENCING)
BECOME_REAPER = 36
"""``PR_SET_CHILD_SUBREAPER`` of ``prctl(2)``: processes whose parent has ended become its children."""


class Taken(NamedTuple):
    """What a stream took: seconds of processor time of all processes, MB of the parent; and its records."""

    seconds: float
    memory: float
    digest: str


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--answers", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", default="0")
    parser.add_argument("--ray", action="store_true", help="with a cluster of Ray's instead of workers")
    parser.add_argument("--score", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.score is not None:
        score(arguments.score, arguments.workers, ray=arguments.ray)
        return
    ctypes.CDLL(None).prctl(BECOME_REAPER, 1)
    with tempfile.TemporaryDirectory() as folder:
        answers = Path(folder) / "answers.jsonl"
        write_answers(answers, arguments.answers, arguments.seed)
        print(f"{arguments.answers:,} answers, all different, and their records", flush=True)
        one, several = taken(answers, 1), taken(answers, arguments.workers, ray=arguments.ray)
    print(f"the same records: {one.digest == several.digest}")
    print(f"with {arguments.workers} workers {several.seconds / one.seconds:.2f} times the processor time")


def write_answers(path: Path, number: int, seed: str) -> None:
    """Write so many answers, a list of id and text a line."""
    suite, make = open_suite(*SUITE), maker(*SUITE)
    seen: set[tuple[str, int]] = set()
    dice = Dice(seed)
    with path.open("w", encoding="utf-8") as file:
        for task_id in islice(cycle(suite.task_ids), number):
            while (known := (task_id, hash(text := make(dice, task_id)))) in seen:
                pass
            seen.add(known)
            file.write(json.dumps([task_id, text]) + "\n")


def taken(answers: Path, workers: int, *, ray: bool = False) -> Taken:
    """What it takes to score a file of answers with so many workers."""
    before = _seconds()
    command = [sys.executable, __file__, "--score", str(answers), "--workers", str(workers)]
    command += ["--ray"] if ray else []
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    with suppress(ChildProcessError):
        while True:  # what starts workers ends after the program that had it started
            os.wait()
    memory, digest, alive = done.stdout.split()
    found = Taken(float(alive) if ray else _seconds() - before, int(memory) / 1000, digest)
    print(f"  workers {workers}: {found.seconds:7.1f} CPU s, parent {found.memory:4.0f} MB", flush=True)
    return found


def _seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def score(answers: Path, workers: int, *, ray: bool) -> None:
    """Write the records of a file of answers beside it; prints the most memory, and their digest."""
    suite, out = open_suite(*SUITE), answers.with_name("records.jsonl")
    with collecting_seldom(), _opened(workers, ray=ray) as scoring:
        write_records(out, scoring.records(suite, "stream", read(answers)))
        alive = time.process_time() + _seconds_below(os.getpid())
    digest = hashlib.sha256()
    with out.open("rb") as file:
        for line in file:
            digest.update(line)
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    print(status.split("VmHWM:")[1].split()[0], digest.hexdigest(), alive)


def _seconds_below(ancestor: int) -> float:
    """The processor time so far of all processes that descend from one, of those too that they waited for."""
    parents, ticks = {}, {}
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            if entry.name.isdigit():
                fields = (entry / "stat").read_text(encoding="utf-8").rpartition(")")[2].split()
                parents[int(entry.name)] = int(fields[1])
                ticks[int(entry.name)] = sum(map(int, fields[11:15]))
    found, below = 0, {ancestor}
    while below:
        below = {process for process, parent in parents.items() if parent in below}
        found += sum(ticks[process] for process in below)
    return found / os.sysconf("SC_CLK_TCK")


def _opened(workers: int, *, ray: bool) -> Scoring:
    if not ray:
        return Scoring(workers)
    from eai.envs.ray_scoring import LOCAL, RayScoring

    return RayScoring(LOCAL, workers)


def read(answers: Path) -> Iterator[Response]:
    with answers.open(encoding="utf-8") as file:
        for line in file:
            yield Response(*json.loads(line))


if __name__ == "__main__":
    main()
