"""Measure the processor time per sample that `eai run` adds to Inspect and the model.

The work of `eai` is timed sample by sample, for every suite: making the scorer of a task (once per task for
all models), scoring an answer, explaining it, and writing the record.

`--difference` adds the cost of asking beyond Inspect alone, including the log of answers. For this, two
solvers ask the same built-in model the same questions in turn: `eai run`'s, and Inspect's own generate
solver. They take turns because runs vary more than the solvers differ. Nothing is scored.

Transition modeling is scored without a planner, whose time is no overhead.

    python -m bench run_overhead [--samples N] [--difference ROUNDS] [--suite DOMAIN ABILITY]
"""

from __future__ import annotations

import argparse
import gc
import json
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import inspect_ai
from inspect_ai.solver import generate

from bench.record import add_write_option, write_figures
from eai.abilities.protocol import PAPER_ABILITIES
from eai.benchmarks.gold_answers import open_gold_answers
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.batch import Scoring
from eai.results.codec import record_to_json
from eai.results.collector import reduce_garbage_collection
from eai.results.responses import Response
from eai.run.job import QuestionJob
from eai.run.tasks import build_task, request_missing_answers
from eai.studies.variation import ModelEndpoint
from eai.tasks.prompts.prompt import Prompt
from eai.tasks.source import Source

MODEL = "eai/oracle"
WARM_UP = 5
PARTS = ("making", "scoring", "explaining", "recording")


@dataclass(frozen=True, slots=True)
class Questions:
    """Questions of a suite, as Inspect's samples."""

    suite: Suite
    prompts: Mapping[str, Prompt]


def measure_processor_ms(work: Callable[[], object]) -> float:
    """Return the processor time of a call in milliseconds."""
    start = time.process_time()
    work()
    return 1000 * (time.process_time() - start)


def measure_processor_ms_without_garbage(work: Callable[[], object]) -> float:
    """Return the processor time of a call in milliseconds, after collecting the garbage of earlier work."""
    gc.collect()
    reduce_garbage_collection()
    return measure_processor_ms(work)


def ask_with_inspect_alone(asked: Questions, folder: Path) -> None:
    """Return a task of Inspect with the questions, Inspect's own solver and the built-in model."""
    task = build_task(asked.suite, asked.prompts, generate())
    inspect_ai.eval(
        task, model=MODEL, log_dir=str(folder), display="none", score=False, temperature=0.0, max_retries=5
    )


def measure_samples(asked: Questions) -> list[dict[str, float]]:
    """Return the milliseconds of each part of `eai`'s work, sample by sample, without one-time costs."""
    suite = asked.suite
    gold = open_gold_answers(suite.benchmark, suite.ability)
    answers = {task_id: gold[task_id].text for task_id in asked.prompts}
    reduce_garbage_collection()
    times = [dict(measure_parts(suite, task_id, text)) for task_id, text in answers.items()]
    return times[WARM_UP:]


def measure_parts(suite: Suite, task_id: str, text: str) -> Iterator[tuple[str, float]]:
    """Return the milliseconds of each part for one answer.

    Records and explanations count as the time that they add.
    """
    yield "making", measure_processor_ms(partial(suite.scorer, task_id))
    scoring = measure_processor_ms(partial(suite.score, task_id, text))
    yield "scoring", scoring
    start = time.process_time()
    (record,) = Scoring().score_records(suite, MODEL, [Response(task_id, text)], explanations=True)
    yield "explaining", max(1000 * (time.process_time() - start) - scoring, 0.0)
    yield "recording", measure_processor_ms(lambda: json.dumps(record_to_json(record)))


def measure_asking(asked: Questions, folder: Path, rounds: int) -> dict[str, float]:
    """Return two times per sample in milliseconds: that of Inspect alone, and the time that `eai` adds."""
    job = QuestionJob(ModelEndpoint(MODEL), asked.suite, asked.prompts)
    ask_with_inspect_alone(asked, folder / "warm")
    alone, ours = [], []
    for number in range(rounds):
        place = folder / str(number)
        alone.append(measure_processor_ms_without_garbage(partial(ask_with_inspect_alone, asked, place)))
        ask = partial(request_missing_answers, job, place / "answers.jsonl", place / "logs")
        ours.append(measure_processor_ms_without_garbage(ask))
    beyond = statistics.median(a - b for a, b in zip(ours, alone, strict=True))
    count = len(asked.prompts)
    return {"inspect_alone": statistics.median(alone) / count, "asking": beyond / count}


def measure(asked: Questions, rounds: int) -> dict[str, float]:
    """Return the median of each part in milliseconds, and of the sum of all parts of `eai`."""
    times = measure_samples(asked)
    result = {part: statistics.median(sample[part] for sample in times) for part in PARTS}
    result["ours"] = statistics.median(sum(sample.values()) for sample in times)
    if rounds:
        with tempfile.TemporaryDirectory() as name:
            result |= measure_asking(asked, Path(name), rounds)
        result["ours"] += result["asking"]
    return result


def measure_suites(samples: int, rounds: int, suite: tuple[str, str] | None) -> dict[str, dict[str, float]]:
    """Measure suites, print a table and a line of JSON, and return the milliseconds of each part by suite."""
    suites = [
        (d, a) for d in ("virtualhome", "behavior") for a in PAPER_ABILITIES if suite in (None, (d, a.value))
    ]
    results: dict[str, dict[str, float]] = {}
    for domain, ability in suites:
        opened = open_suite(domain, ability, source=Source(planner=PlannerChoice.NONE))
        asked = PromptLibrary("official").open(opened.benchmark, ability)
        prompts = dict(list(asked.items())[: samples + WARM_UP])
        result = measure(Questions(opened, prompts), rounds)
        if not results:
            print(f"{'ms a sample':34}" + "".join(f"{name:>14}" for name in result))
        name = f"{domain} {ability.value}"
        results[name] = result
        print(f"{name:34}" + "".join(f"{value:14.2f}" for value in result.values()), flush=True)
    print(json.dumps({"samples": samples, "suites": results}))
    return results


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=90)
    parser.add_argument("--difference", type=int, default=0, metavar="ROUNDS")
    parser.add_argument("--suite", nargs=2, metavar=("DOMAIN", "ABILITY"))
    add_write_option(parser)
    arguments = parser.parse_args()
    suite = None if arguments.suite is None else tuple(arguments.suite)
    results = measure_suites(arguments.samples, arguments.difference, suite)
    if arguments.write:
        ours = [result["ours"] for result in results.values()]
        making = max(result["making"] for result in results.values())
        write_figures(
            "run_overhead",
            {
                "Median ms per sample": f"{min(ours):.1f} to {max(ours):.1f}",
                "Making the scorer of a task, once, at most": round(making, 1),
            },
        )
