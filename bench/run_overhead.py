"""What a run costs beyond Inspect and the model: processor time a sample, ours beside Inspect alone.

Inspect alone is its own generate solver on the same questions to the same built-in model, not scored. Ours
is timed sample by sample: writing an answer down, scoring it, explaining it. `--difference` also runs all of
`eai run`'s asking beside Inspect alone, whose own time varies more than what is to be measured.

    python bench/run_overhead.py [--samples N] [--difference ROUNDS]
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import inspect_ai
from inspect_ai.solver import generate

from eai.abilities.protocol import Ability, Domain, Protocol
from eai.abilities.suite import open_suite
from eai.prompts.official import official_prompts
from eai.prompts.prompt import Prompt
from eai.run.answers import open_answer_book
from eai.run.desk import Desk
from eai.run.evaluation import obtain_answers
from eai.run.job import Endpoint, Job
from eai.run.journal import Answer, Journal, Usage
from eai.run.tasks import build_task

DOMAIN, ABILITY = Domain.VIRTUALHOME, Ability.ACTION_SEQUENCING
MODEL = "eai/oracle"
WARM_UP = 5


def processor_ms(work: Callable[[], object]) -> float:
    """Processor time of a call, in milliseconds."""
    start = time.process_time()
    work()
    return 1000 * (time.process_time() - start)


def inspect_alone(prompts: Mapping[str, Prompt], folder: Path) -> None:
    """The questions without anything of ours but the model that answers."""
    task = build_task(DOMAIN, ABILITY, prompts, generate(), Protocol.STRICT)
    inspect_ai.eval(
        task, model=MODEL, log_dir=str(folder), display="none", score=False, temperature=0.0, max_retries=5
    )


def write_down(desk: Desk, task_id: str, prompt: Prompt, text: str) -> None:
    """What happens to an answer when it arrives."""
    request = desk.job.request_sha256(prompt)
    desk.take(Answer(task_id, 1, request, prompt.sha256, text, "", "stop", (), Usage(1, 1)))


def by_sample(prompts: Mapping[str, Prompt], folder: Path) -> dict[str, float]:
    """The median of each part of what we do for a sample."""
    suite = open_suite(DOMAIN, ABILITY)
    gold = open_answer_book(DOMAIN, ABILITY).gold
    desk = Desk(Job(Endpoint(MODEL), DOMAIN, ABILITY, prompts), Journal(folder / "answers.jsonl"))
    parts: dict[str, list[float]] = {"journal_ms": [], "scoring_ms": [], "explaining_ms": []}
    for task_id, prompt in prompts.items():
        text = gold(task_id).text
        parts["journal_ms"].append(processor_ms(partial(write_down, desk, task_id, prompt, text)))
        parts["scoring_ms"].append(processor_ms(partial(suite.score, task_id, text)))
        parts["explaining_ms"].append(processor_ms(partial(suite.scorer(task_id).explain, text)))
    return {name: statistics.median(times[WARM_UP:]) for name, times in parts.items()}


def main(samples: int, rounds: int) -> None:
    """Measure and print, as a table and as one JSON line."""
    prompts = dict(list(official_prompts(DOMAIN, ABILITY).items())[:samples])
    job = Job(Endpoint(MODEL), DOMAIN, ABILITY, prompts)
    alone, asking = [], []
    with tempfile.TemporaryDirectory() as name:
        inspect_alone(prompts, Path(name, "warm"))
        result = by_sample(prompts, Path(name, "by_sample"))
        for number in range(max(rounds, 1)):
            folder = Path(name, str(number))
            alone.append(processor_ms(partial(inspect_alone, prompts, folder)) / samples)
            if rounds:
                ask = partial(obtain_answers, job, folder / "answers.jsonl", folder / "logs")
                asking.append(processor_ms(ask) / samples)
    result["inspect_alone_ms"] = statistics.median(alone)
    if rounds:
        differences = (a - b for a, b in zip(asking, alone, strict=True))
        result["asking_beyond_inspect_ms"] = statistics.median(differences)
    for label, value in result.items():
        print(f"{label:26} {value:8.2f}")
    print(json.dumps({"samples": samples, **result}))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--samples", type=int, default=200)
    parser.add_argument("--difference", type=int, default=0, metavar="ROUNDS")
    arguments = parser.parse_args()
    main(arguments.samples, arguments.difference)
