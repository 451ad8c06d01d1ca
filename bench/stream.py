"""Measure the scoring of a million answers in one process, with workers, and on Ray.

The answers are mutated plans of VirtualHome (`mutated_plans`). `--different` of them are distinct, and each
is a sample of its task. They are written beforehand, which does not count. Then ``eai score`` reads and
scores the file in one process, and again with workers. The processor time includes all processes with their
start and end; the memory is that of the largest process. On Ray only the driver counts, because its other
processes are not waited for.

``--simulated N`` adds N workers that score one batch and sleep for as long at every other batch. The share
of a core that their driver uses shows how many workers it can keep busy. Linux only.

    python -m bench stream [--answers 1000000] [--different 20000] [--workers 2] [--ray] [--simulated 16]
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
from collections.abc import Sequence
from contextlib import suppress
from itertools import count, islice
from pathlib import Path
from typing import NamedTuple

from bench.record import add_write_option, write_figures
from differential.mutated_answers import maker
from differential.mutations import Dice
from eai.abilities.protocol import Ability
from eai.benchmarks.suite import open_suite
from eai.results.batch import Scoring
from eai.results.options import ScoringOptions
from eai.results.records import RECORDS, SUMMARY, RecordBatch, write_record_batches
from eai.results.responses import ResponseRow, read_responses
from eai.results.workers import WorkerPool

SUITE = ("virtualhome", Ability.ACTION_SEQUENCING)
BECOME_REAPER = 36
"""``PR_SET_CHILD_SUBREAPER`` of ``prctl(2)``: this process adopts processes whose parent has ended."""
BATCH = 256


class StreamCost(NamedTuple):
    """Cost of scoring: seconds of processor time, MB of the largest process, and the printed output."""

    seconds: float
    memory: float
    digests: tuple[str, str]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--answers", type=int, default=1_000_000)
    parser.add_argument("--different", type=int, default=20_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--simulated", type=int, default=0)
    parser.add_argument("--explanations", action=argparse.BooleanOptionalAction, default=False)
    parser.add_argument("--ray", action="store_true", help="with a cluster of Ray's instead of workers")
    add_write_option(parser)
    arguments = parser.parse_args()
    ctypes.CDLL(None).prctl(BECOME_REAPER, 1)
    explained = "--explanations" if arguments.explanations else "--no-explanations"
    with tempfile.TemporaryDirectory() as folder:
        answers = Path(folder) / "m_outputs.jsonl"
        write_answers(answers, arguments.answers, arguments.different)
        print(f"{arguments.answers:,} answers, {arguments.different:,} of them different", flush=True)
        if arguments.simulated:
            measure_simulated_workers(answers, arguments.simulated, explanations=arguments.explanations)
            return
        one = measure_stream(answers, [explained])
        ray = ["--ray", "local"] if arguments.ray else []
        several = measure_stream(answers, [explained, "--workers", str(arguments.workers), *ray])
    print(f"the same records and summary: {one.digests == several.digests}")
    print(f"with {arguments.workers} workers {several.seconds / one.seconds:.2f} times the processor time")
    if arguments.write:
        seconds = f"{one.seconds:.1f}, {several.seconds:.1f}"
        write_figures(
            "stream",
            {
                "CPU s through `eai score`: one process, with workers": seconds,
                "Largest process": f"{max(one.memory, several.memory):.0f} MB",
            },
        )


def write_answers(path: Path, number: int, different: int) -> None:
    """Write answers, each a numbered sample of its task."""
    suite, make = open_suite(*SUITE), maker(*SUITE)
    dice = Dice("0")
    rounds = -(-different // len(suite.task_ids))
    texts = {task_id: [make(dice, task_id) for _ in range(rounds)] for task_id in suite.task_ids}
    with path.open("w", encoding="utf-8") as file:
        numbered = ((sample, task_id) for sample in count() for task_id in suite.task_ids)
        for sample, task_id in islice(numbered, number):
            text = texts[task_id][sample % rounds]
            row = {"identifier": task_id, "sample": sample, "llm_output": text}
            file.write(json.dumps(row) + "\n")


def measure_stream(answers: Path, options: Sequence[str]) -> StreamCost:
    """Score a file of answers, and return the cost."""
    out = answers.with_name("out")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    where = ["--domain", SUITE[0], "--ability", SUITE[1].value, "--out", str(out)]
    subprocess.run(
        [sys.executable, "-m", "eai", "score", str(answers), *where, *options],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    with suppress(ChildProcessError):
        while True:  # the process that starts workers ends after the program
            os.wait()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    digests = [hashlib.sha256(), hashlib.sha256()]
    for digest, name in zip(digests, (RECORDS, SUMMARY), strict=True):
        with (out / name).open("rb") as file:
            for line in file:
                digest.update(line)
    found = StreamCost(seconds, after.ru_maxrss / 1024, (digests[0].hexdigest(), digests[1].hexdigest()))
    print(
        f"  {' '.join(options):35} {seconds:7.1f} CPU s, at most {found.memory:4.0f} MB a process", flush=True
    )
    return found


class Simulated:
    """Work of a simulated worker: it scores one batch, and sleeps for as long at every other batch."""

    def __init__(self, answers: Path, *, explanations: bool) -> None:
        suite = open_suite(*SUITE)
        settings = ScoringOptions(explanations=explanations)
        file = answers.with_name("batch_outputs.jsonl")
        rows = read_responses(answers, suite.task_ids, samples=True).read_rows()
        for number in (2 * len(suite.task_ids), BATCH):  # the first batches include making all tasks
            some = islice(rows, number)
            file.write_bytes(b"".join(row for row in some if isinstance(row, bytes)))
            batch = read_responses(file, suite.task_ids, samples=True)
            start = time.process_time()
            self.parts = [*Scoring().score_in_batches(suite, batch, {}, settings)]
            self.seconds = (time.process_time() - start) / number

    def __call__(self, rows: Sequence[ResponseRow]) -> list[RecordBatch]:
        time.sleep(len(rows) * self.seconds)
        return self.parts


def measure_simulated_workers(answers: Path, workers: int, *, explanations: bool) -> None:
    """Print the processor time of a driver with this number of simulated workers."""
    work = Simulated(answers, explanations=explanations)
    suite = open_suite(*SUITE)
    start = time.process_time()
    file = read_responses(answers, suite.task_ids, samples=True)
    reading = time.process_time() - start
    number = len(file.responses)
    with WorkerPool(workers) as scoring:
        parts = scoring.map_batches(work, file.read_rows(), batch_sizes=(BATCH, BATCH))
        start = time.process_time()
        write_record_batches(answers.with_name("simulated"), parts)
        driving = time.process_time() - start
    busy = number * work.seconds / workers
    size = answers.with_name("simulated").joinpath(RECORDS).stat().st_size // number
    print(f"  {1e6 * work.seconds:.0f} microseconds an answer, {size:,} bytes a record; {workers} workers")
    print(
        f"  the driver: {1e6 * driving / number:.1f} microseconds an answer, {driving / busy:.2f} of a core"
    )
    print(f"  before that it checks the file: {1e6 * reading / number:.1f} microseconds an answer")
