"""Measure processor time and memory of `eai analyze all` on the records of many models.

    python -m bench analyses RECORDS... [--models 18]

The exit status is 1 above 60 CPU seconds or 1 GB. For comparison, a loop of fixed length is timed, too,
because a busy machine needs more processor time for equal work.
"""

from __future__ import annotations

import argparse
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from bench.record import add_write_option, write_figures
from eai.results.runs import find_record_files

CPU_SECONDS, MEGABYTES = 60, 1024
LOOP = 20_000_000
MODEL = re.compile(r'"model": "([^"]*)"')


def main() -> None:
    """Run the analyses and print their cost."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("records", type=Path, nargs="+")
    parser.add_argument("--models", type=int, default=18)
    add_write_option(parser)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="eai-bench-") as folder:
        records, out = Path(folder) / "records", Path(folder) / "out"
        copied = copy(find_record_files(arguments.records), records, arguments.models)
        command = "from eai.cli import main; main()"
        words = ["analyze", "all", str(records), "--out", str(out)]
        subprocess.run([sys.executable, "-c", command, *words], check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds, megabytes = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    additions = f"{LOOP:,} additions: {measure_loop():.2f} CPU s"
    print(f"{copied} runs: {seconds:.1f} CPU s, {megabytes:.0f} MB; {additions}")
    if arguments.write:
        cost = f"{seconds:.1f} s, {megabytes:.0f} MB, {copied} runs"
        write_figures("analyses", {"CPU time, memory and runs of `eai analyze all`": cost})
    sys.exit(seconds > CPU_SECONDS or megabytes > MEGABYTES)


def copy(files: Sequence[Path], folder: Path, models: int) -> int:
    """Copy records under new model names until each suite has enough runs, and return the number of runs."""
    suites: dict[tuple[str, ...], list[str]] = {}
    for file in files:
        text = file.read_text(encoding="utf-8")
        suites.setdefault(file.parts[:-2], []).append(text)
    copied = 0
    for texts in suites.values():
        for number in range(models):
            renamed = MODEL.sub(rf'"model": "\1-{number // len(texts)}"', texts[number % len(texts)])
            target = folder / str(copied) / "records.jsonl"
            target.parent.mkdir(parents=True)
            target.write_text(renamed, encoding="utf-8")
            copied += 1
    return copied


def measure_loop() -> float:
    """Return the CPU seconds of a loop of fixed length."""
    begun, total = time.process_time(), 0
    for number in range(LOOP):
        total += number & 3
    return time.process_time() - begun
