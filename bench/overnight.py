"""Measure what a night's work costs at two sizes, and extrapolate what is linear.

The goals: 100,000 generated tasks of each household, 100,000 world-model questions, a run of 100,000 samples,
10 million scored answers, and a report of 100 models. Each command runs in one process, at a trivial size, at
a quarter of the chosen size, and at the chosen size, which is the goal times `--scale`. The trivial size
stands for the start of the command, and is subtracted before the exponent of growth is computed. Processor
time and memory are those that the system states for the process.

Hours at the goal continue the line through the last two sizes. They are left out if the exponent is above
1.15. Hours for generated tasks leave out that copies become more frequent. Tasks are not extrapolated if the
command estimates that there are fewer different ones than the goal. Hours on eight cores are the hours of one
process divided by eight, if the command takes `--workers`. Questions of one kind and form have one worker at
a time, so questions are divided by 4.3. Memory is not extrapolated.

The report is measured at its goal at any scale, but only if RECORDS are given: a folder with the records of a
model, preferably of all eight suites, with explanations. They are copied under other names.

    python -m bench overnight [--scale 0.002] [--runs 3] [--lines virtualhome run ...] [--records RECORDS ...]
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from bench.explorer import measure_opening
from bench.growth import estimate_exponent
from bench.record import add_write_option, write_rows
from bench.report import copy_records_for_models
from bench.result import Figure
from bench.stream import write_answers
from eai.benchmarks.generator.spec import SeedRejectionReason
from eai.benchmarks.registry import PAPER_BENCHMARKS, get_title
from eai.results.runs import find_record_files

_EAI = [sys.executable, "-m", "eai"]
_CORES = 8
_MAX_EXPONENT = 1.15
"""Maximum exponent of growth that counts as linear. Below it is the noise of a busy machine."""

_QUESTION_SPEEDUP = 4.3
"""How many times faster eight cores write questions.

It follows from the shares of kinds and forms in the time of 288 questions. The slowest takes 22 %.
"""

_RUN_TASKS = 60
"""Number of different tasks of a run. They are repeated under other ids."""

_DIFFERENT_SHARE = 50
"""Number of answers to score for each different answer."""

_COPIES = "Copies refused"
_OPENING = "Explorer of 100 models opens: seconds, CPU s"


class ChildCost(NamedTuple):
    """Cost of a command: its processor seconds, and the largest resident memory in MB."""

    seconds: float
    megabytes: int


class WorkLine(NamedTuple):
    """A line of the table.

    Attributes:
        goal: words for the goal.
        command: command whose cost is measured.
        size: size of the goal.
        measure: returns the cost at a size, in an empty folder.
        workers: whether the command takes `--workers`.
        estimate: estimates from the results in a folder how many different tasks there are; None if unknown.
            If they are fewer than the goal, the cost is not extrapolated.
        speedup: how many times faster the command is on eight cores.
    """

    goal: str
    command: str
    size: int
    measure: Callable[[int, Path], ChildCost]
    workers: bool = True
    estimate: Callable[[Path], int | None] = lambda folder: None
    speedup: float = _CORES


def main() -> None:
    lines = make_lines(())
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scale", type=float, default=0.01, help="share of the goal that is measured")
    parser.add_argument("--runs", type=int, default=1, help="runs of each size; the least time counts")
    parser.add_argument("--lines", nargs="+", choices=list(lines), default=list(lines))
    parser.add_argument("--records", type=Path, nargs="+", default=[], help="of one model, for the report")
    add_write_option(parser)
    arguments = parser.parse_args()
    lines = make_lines(arguments.records)
    rows: list[Sequence[Figure]] = []
    figures: dict[str, Figure] = {}
    for name in arguments.lines:
        if name == "report" and not arguments.records:
            print("report: not measured without --records")
            continue
        with tempfile.TemporaryDirectory() as folder:
            scale = 1.0 if name == "report" else arguments.scale
            row = measure_line(lines[name], scale, Path(folder), arguments.runs)
            figures |= read_further_figures(name, Path(folder, "0_2"))
        rows.append(row)
        print(f"| {' | '.join(map(str, row))} |", flush=True)
    for title, figure in figures.items():
        print(f"{title}: {figure}")
    if arguments.write:
        write_rows("overnight", rows)
        write_rows("overnight", [*figures.items()], table=1)


def make_lines(records: Sequence[Path]) -> Mapping[str, WorkLine]:
    """Return the lines of the table by name."""
    return {
        **{
            like: WorkLine(
                f"100,000 tasks, {get_title(like)}",
                "eai generate",
                100_000,
                partial(measure_generation, like),
                estimate=read_estimated_tasks,
            )
            for like in PAPER_BENCHMARKS
        },
        "questions": WorkLine(
            "100,000 questions, VirtualHome",
            "eai export questions",
            100_000,
            measure_questions,
            speedup=_QUESTION_SPEEDUP,
        ),
        "run": WorkLine(
            "a run of 100,000 samples, VirtualHome", "eai run", 100_000, measure_run, workers=False
        ),
        "answers": WorkLine("10,000,000 plans, VirtualHome", "eai score", 10_000_000, measure_scoring),
        "report": WorkLine(
            "a report of 100 models", "eai report", 100, partial(measure_report, records), workers=False
        ),
    }


def measure_line(line: WorkLine, scale: float, folder: Path, runs: int = 1) -> Sequence[Figure]:
    """Return the row of a line. The sizes take turns, so that other work on the machine slows all down."""
    largest = max(8, round(line.size * scale))
    costs: dict[int, ChildCost] = {}
    for run in range(runs):
        for number, size in enumerate((1, largest // 4, largest)):
            place = folder / f"{run}_{number}"
            place.mkdir()
            cost = line.measure(size, place)
            costs[size] = min(cost, costs.get(size, cost))
    start, few, many = costs.values()
    sizes = [*costs][1:]
    growth = estimate_exponent(
        {sizes[0]: few.seconds - start.seconds, sizes[1]: many.seconds - start.seconds}
    )
    hours: Figure = "not extrapolated"
    on_cores: Figure = hours
    different = line.estimate(place)
    is_enough = different is None or different >= line.size
    if is_enough and growth <= _MAX_EXPONENT:
        share = (line.size - sizes[1]) / (sizes[1] - sizes[0])
        seconds = many.seconds + share * (many.seconds - few.seconds)
        hours = round(seconds / 3600, 2)
        on_cores = round(seconds / 3600 / line.speedup, 2) if line.workers else "one process"
    measured = "; ".join(
        f"{size:,}: {cost.seconds:,.1f} s, {cost.megabytes:,} MB" for size, cost in costs.items()
    )
    return (line.goal, f"`{line.command}`", measured, round(growth, 2), hours, on_cores)


def read_estimated_tasks(folder: Path) -> int | None:
    """Return the estimated number of different tasks, as `eai generate` wrote it; None if it wrote none."""
    made = json.loads((folder / "generated.json").read_text(encoding="utf-8"))["sets"]["tasks"]
    different = made["estimated_tasks"]
    return None if different is None else int(different)


def measure_generation(like: str, size: int, folder: Path) -> ChildCost:
    """Return the cost of generating tasks of a household."""
    return run_child(["generate", "--like", like, "--n", str(size), "--out", str(folder)])


def measure_questions(size: int, folder: Path) -> ChildCost:
    """Return the cost of writing questions on VirtualHome."""
    file = folder / "questions.jsonl"
    return run_child(["export", "questions", "--domain", "virtualhome", "--n", str(size), "--out", str(file)])


def measure_run(size: int, folder: Path) -> ChildCost:
    """Return the cost of a run of `eai/oracle` on generated VirtualHome tasks."""
    run_child(["generate", "--like", "virtualhome", "--n", str(min(size, _RUN_TASKS)), "--out", str(folder)])
    lines = [json.loads(line) for line in (folder / "tasks.jsonl").read_text(encoding="utf-8").splitlines()]
    tasks = folder / "many.jsonl"
    with tasks.open("w", encoding="utf-8") as file:
        for number in range(size):
            line = lines[number % len(lines)]
            file.write(json.dumps({**line, "id": f"{line['id']}-{number}"}) + "\n")
    asked = ["--domain", str(tasks), "--ability", "action_sequencing", "--out", str(folder / "runs")]
    return run_child(["run", "--model", "eai/oracle", *asked, "--quiet"])


def measure_scoring(size: int, folder: Path) -> ChildCost:
    """Return the cost of scoring plans of VirtualHome."""
    answers = folder / "m_outputs.jsonl"
    write_answers(answers, size, -(-size // _DIFFERENT_SHARE))
    where = ["--domain", "virtualhome", "--ability", "action_sequencing", "--out", str(folder / "out")]
    return run_child(["score", str(answers), *where, "--no-explanations"])


def measure_report(records: Sequence[Path], size: int, folder: Path) -> ChildCost:
    """Return the cost of the report of as many models, which are copies of one model."""
    for number, file in enumerate(find_record_files(records)):
        copy_records_for_models(file, folder / "runs" / str(number), size)
    return run_child(["report", str(folder / "runs"), "--out", str(folder)])


def read_further_figures(name: str, folder: Path) -> Mapping[str, Figure]:
    """Return figures that are not extrapolated, from the results at the largest size of a line."""
    if name == "report":
        seconds, opening_seconds = measure_opening(folder / "explorer.html")
        answers = sum(file.read_bytes().count(b"\n") for file in find_record_files([folder / "runs"]))
        return {_OPENING: f"{seconds:.1f}, {opening_seconds:.1f} ({answers:,} answers)"}
    if name not in PAPER_BENCHMARKS:
        return {}
    made = json.loads((folder / "generated.json").read_text(encoding="utf-8"))["sets"]["tasks"]
    copies = made["rejected"].get(SeedRejectionReason.COPY.value, 0)
    percent, different = 100 * copies / (copies + made["tasks"]), made["estimated_tasks"]
    estimate = "" if different is None else f", at least {different:,} different"
    return {f"{_COPIES}, {get_title(name)}": f"{percent:.1f} % at {made['tasks']:,} tasks{estimate}"}


def run_child(words: Sequence[str]) -> ChildCost:
    """Run a command of eai, and return its cost."""
    command = [*_EAI, *words]
    silent = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawn(command[0], command, os.environ, file_actions=silent)
    _, status, usage = os.wait4(child, 0)
    if status:
        sys.exit(f"eai {' '.join(words)}: exit status {os.waitstatus_to_exitcode(status)}")
    return ChildCost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss // 1024)
