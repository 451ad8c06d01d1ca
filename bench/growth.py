"""Measure how processor time grows with the size of the input; with `--out`, draw a picture.

    python -m bench growth [CURVE ...] [--most N] [--out docs/images/growth.png]

Each curve has the minimum time of a few runs at sizes that at least double. Its exponent is the slope of the
logarithms over the upper half of the sizes, where fixed costs weigh least. bench/README.md explains each
exponent well above 1. The world is ``examples/lamps`` with more lamps.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle, islice
from pathlib import Path
from typing import NamedTuple

import eai.world as w
from bench.record import add_write_option, write_rows
from differential.reference_child import cpu_seconds
from eai import Benchmark, make_task, use_tasks
from eai.abilities.protocol import Ability
from eai.benchmarks.gold_answers import make_noisy_answer, open_gold_answers
from eai.benchmarks.suite import open_suite
from eai.results.batch import Scoring
from eai.results.collector import reduce_garbage_collection
from eai.results.options import ScoringOptions
from eai.results.plots import MODEL_COLORS, use_plot_style
from eai.results.records import write_record_batches
from eai.results.responses import read_responses
from eai.world import State

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "lamps"))

from lamps import domain

Work = Callable[[], object]
"""Repeatable work that is timed."""

PLANS, SUBGOALS = Ability.ACTION_SEQUENCING, Ability.SUBGOAL_DECOMPOSITION
OPERATORS = Ability.TRANSITION_MODELING


class Curve(NamedTuple):
    """Measured quantity, a function that prepares work of one size, and the sizes in ascending order."""

    title: str
    prepare: Callable[[int, Path], Work]
    sizes: Sequence[int]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("curves", nargs="*", metavar="CURVE", help=f"of {', '.join(CURVES)}; all if none")
    parser.add_argument("--most", type=int, default=10**9, help="no size above this one")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--out", type=Path, help="the picture to write")
    add_write_option(parser)
    arguments = parser.parse_args()
    if unknown := set(arguments.curves) - CURVES.keys():
        parser.error(f"unknown curves: {', '.join(sorted(unknown))}")
    taken = {}
    for name in arguments.curves or CURVES:
        sizes = [size for size in CURVES[name].sizes if size <= arguments.most]
        taken[name] = {size: measure_least_seconds(CURVES[name], size, arguments.runs) for size in sizes}
        print(f"| {' | '.join(make_row(name, taken[name]))} |", flush=True)
    if arguments.write:
        write_rows("growth", [make_row(name, of_size) for name, of_size in taken.items()])
    if arguments.out is not None:
        draw_curves(taken, arguments.out)


def measure_least_seconds(curve: Curve, size: int, runs: int) -> float:
    """Return the minimum processor seconds of some runs, with the programs that they start."""
    with tempfile.TemporaryDirectory() as folder:
        work = curve.prepare(size, Path(folder))
        found = [measure_seconds(work)]
        while len(found) < runs and sum(found) < 10:
            found.append(measure_seconds(work))
    return min(found)


def measure_seconds(work: Work) -> float:
    before = cpu_seconds()
    work()
    return cpu_seconds() - before


def estimate_exponent(taken: Mapping[int, float]) -> float:
    """Return the slope of the logarithms over the upper half of the sizes."""
    import numpy as np

    upper = [*taken.items()][len(taken) // 2 - (len(taken) < 4) :]
    sizes, seconds = np.log(upper).T
    return float(np.polyfit(sizes, seconds, 1)[0])


def make_row(name: str, taken: Mapping[int, float]) -> list[str]:
    told = ", ".join(f"{size:,}: {1000 * seconds:,.3g}" for size, seconds in taken.items())
    return [CURVES[name].title, told, f"{estimate_exponent(taken):.2f}"]


def draw_curves(taken: Mapping[str, Mapping[int, float]], path: Path) -> None:
    """Draw all curves on one pair of logarithmic axes, each with its exponent."""
    with use_plot_style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 3.6), layout="constrained")
        axes = figure.subplots()
        marks = cycle(("o-", "s--"))
        for color, mark, (name, of_size) in zip(cycle(MODEL_COLORS), marks, taken.items(), strict=False):
            label = f"{CURVES[name].title}: {estimate_exponent(of_size):.2f}"
            milliseconds = [1000 * s for s in of_size.values()]
            axes.plot(list(of_size), milliseconds, mark, color=color, label=label, markersize=4)
        axes.set(
            xscale="log", yscale="log", xlabel="size", ylabel="CPU ms", xticks=[1, 100, 10_000, 1_000_000]
        )
        axes.xaxis.set_major_formatter("{x:,.7g}")
        axes.yaxis.set_major_formatter("{x:,.7g}")
        figure.legend(loc="outside right upper", title="exponents", frameon=False)
        figure.savefig(path, dpi=100, metadata={"Software": None})


def make_lamp_benchmark(number: int) -> Benchmark:
    """Return a task in which a robot must switch on a number of lamps."""
    task = make_task("light", "Switch all lamps on.", make_dark_state(number), "forall l: lamp. (lit(l))")
    return Benchmark("many-lamps", domain, use_tasks(task))


def make_dark_state(number: int) -> State:
    """Return the state in which no lamp is lit."""
    kinds = {"robot": "robot", **{f"lamp_{n}": "lamp" for n in range(number)}}
    return w.Scene(domain.vocabulary, kinds, agent="robot").state([])


def prepare_scoring(benchmark: Benchmark, ability: Ability, answer: object, *, fails: bool = False) -> Work:
    """Return the work of scoring an answer to the only task of a benchmark, which is opened beforehand."""
    suite, text = open_suite(benchmark, ability), json.dumps(answer)
    (task_id,) = suite.task_ids
    suite.score(task_id, "[]")

    def work() -> None:
        if (suite.score(task_id, text).error is not None) != fails:
            raise SystemExit(f"unexpected verdict on the measured answer: {text[:200]}")

    return work


def make_plan(names: Sequence[str]) -> list[dict[str, str]]:
    return [{"action": "GO", "object": name} for name in names]


def prepare_plan_of_length(size: int, _: Path) -> Work:
    """Prepare a plan that goes back and forth between two lamps; its size is the number of steps."""
    return prepare_scoring(
        make_lamp_benchmark(2), PLANS, make_plan([*islice(cycle(["lamp_0", "lamp_1"]), size)])
    )


def prepare_plan_with_many_objects(size: int, _: Path) -> Work:
    """Prepare a plan whose steps each go to another lamp; its size is the number of steps."""
    return prepare_scoring(make_lamp_benchmark(size), PLANS, make_plan([f"lamp_{n}" for n in range(size)]))


def prepare_scene_with_many_objects(size: int, _: Path) -> Work:
    """Prepare a plan of ten steps in a scene; its size is the number of objects of the scene."""
    return prepare_scoring(
        make_lamp_benchmark(size), PLANS, make_plan([*islice(cycle(["lamp_0", "lamp_1"]), 10)])
    )


def prepare_subgoals(size: int, _: Path) -> Work:
    """Prepare subgoals that each need an action; the size is their number."""
    lines = [*islice(cycle(["at(robot, lamp_0)", "at(robot, lamp_1)"]), size)]
    return prepare_scoring(make_lamp_benchmark(2), SUBGOALS, {"output": lines})


def prepare_conjuncts(size: int, _: Path) -> Work:
    """Prepare a subgoal that two actions reach; its size is the number of conjuncts."""
    others = [f"not lit(lamp_{n})" for n in range(1, size)]
    return prepare_scoring(
        make_lamp_benchmark(size), SUBGOALS, {"output": [" and ".join(["lit(lamp_0)", *others])]}
    )


def prepare_distant_subgoal(size: int, _: Path) -> Work:
    """Prepare a subgoal that needs more actions than the limit; its size is the number of conjuncts."""
    line = " and ".join(f"lit(lamp_{n})" for n in range(size))
    return prepare_scoring(make_lamp_benchmark(size), SUBGOALS, {"output": [line]}, fails=True)


def prepare_nested_subgoal(size: int, _: Path) -> Work:
    """Prepare a subgoal in parentheses; its size is the number of parentheses."""
    return prepare_scoring(
        make_lamp_benchmark(2), SUBGOALS, {"output": [f"{'(' * size}at(robot, lamp_0){')' * size}"]}
    )


def prepare_operators(size: int, _: Path) -> Work:
    """Prepare operators to be compared and planned with; the size is their number."""
    x = w.Variable("x")
    done = [w.Predicate(f"done_{n}", 1) for n in range(size)]
    made = w.Domain(
        "chores",
        w.Vocabulary(tuple(done)),
        tuple(w.Operator(f"DO_{n}", (x,), (), (w.Add(each(x)),)) for n, each in enumerate(done)),
    )
    start = w.Scene(made.vocabulary, {"robot": "robot", "house": "house"}, agent="robot").state([])
    goal = " and ".join(f"{each.name}(house)" for each in done)
    benchmark = Benchmark("chores", made, use_tasks(make_task("all", "Do all chores.", start, goal)))
    gold = open_gold_answers(benchmark, OPERATORS)["all"].text
    return prepare_scoring(benchmark, OPERATORS, json.loads(gold))


def write_many_answers(tasks: int, samples: int, folder: Path) -> tuple[Benchmark, Path]:
    """Return a benchmark with equal tasks, and a file with samples of answers to them."""
    start = make_dark_state(3)
    made = [make_task(str(n), "Switch on.", start, "forall l: lamp. (lit(l))") for n in range(tasks)]
    path = folder / "m_outputs.jsonl"
    text = json.dumps(make_plan(["lamp_0", "lamp_1"]))
    rows = (
        {"identifier": str(n), "sample": s, "llm_output": text} for s in range(samples) for n in range(tasks)
    )
    with path.open("w") as file:
        file.writelines(f"{json.dumps(each)}\n" for each in rows)
    return Benchmark("many-tasks", domain, use_tasks(*made)), path


def prepare_scoring_of_file(benchmark: Benchmark, answers: Path) -> Work:
    """Score a file in the way of `eai score`."""

    def work() -> None:
        suite = open_suite(benchmark, PLANS)
        file = read_responses(answers, suite.task_ids, samples=True)
        reduce_garbage_collection()
        parts = Scoring().score_in_batches(suite, file, {}, ScoringOptions(explanations=False))
        write_record_batches(answers.with_name("out"), parts)

    return work


def prepare_many_tasks(size: int, folder: Path) -> Work:
    """Prepare a file with one answer to each task; its size is the number of tasks."""
    return prepare_scoring_of_file(*write_many_answers(size, 1, folder))


def prepare_many_answers(size: int, folder: Path) -> Work:
    """Prepare a file of answers to a hundred tasks; its size is the number of answers."""
    return prepare_scoring_of_file(*write_many_answers(100, size // 100, folder))


def prepare_report(size: int, folder: Path) -> Work:
    """Prepare a report, timed with the start of its process; its size is the number of models."""
    (folder / "runs").mkdir()
    benchmark = make_lamp_benchmark(3)
    book = open_gold_answers(benchmark, PLANS)
    suite = open_suite(benchmark, PLANS)
    for number in range(size):
        path = folder / f"model-{number:03}_outputs.json"
        text = make_noisy_answer(book, "light", 0.3, str(number)).text
        path.write_text(json.dumps([{"identifier": "light", "llm_output": text}]))
        file = read_responses(path, suite.task_ids)
        parts = Scoring().score_in_batches(suite, file, {}, ScoringOptions(explanations=True))
        write_record_batches(folder / "runs" / path.stem, parts)
    command = [sys.executable, "-m", "eai", "report", "runs", "--out", "report", "--no-prompts"]
    return lambda: subprocess.run(command, cwd=folder, check=True, capture_output=True)


CURVES = {
    "length": Curve("steps of a plan", prepare_plan_of_length, (10, 100, 1_000, 10_000)),
    "touched": Curve(
        "steps, each to another object", prepare_plan_with_many_objects, (10, 100, 1_000, 10_000)
    ),
    "objects": Curve("objects of a scene", prepare_scene_with_many_objects, (10, 100, 1_000, 10_000)),
    "subgoals": Curve("subgoals", prepare_subgoals, (10, 100, 1_000)),
    "conjuncts": Curve("conjuncts of a subgoal", prepare_conjuncts, (2, 4, 8, 16, 32)),
    "far": Curve("conjuncts out of reach", prepare_distant_subgoal, (2, 4, 8, 16, 32)),
    "nesting": Curve("parentheses", prepare_nested_subgoal, (10, 100, 1_000)),
    "operators": Curve("operators", prepare_operators, (2, 4, 8, 16, 32, 64)),
    "tasks": Curve("tasks of a file", prepare_many_tasks, (100, 1_000, 10_000, 100_000)),
    "answers": Curve("answers of a file", prepare_many_answers, (1_000, 10_000, 100_000, 1_000_000)),
    "models": Curve("models of a report", prepare_report, (2, 20, 200)),
}
