from __future__ import annotations

import pickle
from functools import partial
from itertools import islice

import pytest

from benchmarks.generator.worlds import generator
from eai.base.errors import InputError
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator.generator import generate_from_seeds
from eai.benchmarks.generator.seed_batches import (
    make_tasks_from_seed_batch,
    open_generator,
    unpickle_task_generation_outcome,
)
from eai.benchmarks.generator.seeds import select_tasks
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import GeneratedTask, TaskSpecification
from eai.benchmarks.registry import find_benchmark
from eai.results.workers import WorkerPool
from eai.tasks.source import Source
from eai.tasks.task_lines import write_task_line

pytestmark = pytest.mark.usefixtures("data_store")


def _keep_task(generated: GeneratedTask, benchmark: Benchmark) -> GeneratedTask:
    return generated


def test_a_killed_worker_loses_and_repeats_no_seed() -> None:
    benchmark, source = find_benchmark("behavior"), Source()
    opened = open_generator(TaskSpecification("behavior", benchmark.tasks(source).sha256), source)
    vocabulary = benchmark.domain.vocabulary
    with WorkerPool(2) as pool:
        pickled = pool.map_batches(
            partial(make_tasks_from_seed_batch, _keep_task, opened),
            make_seeds("tasks", 1),
            batch_sizes=(1, 4),
        )
        judged = (unpickle_task_generation_outcome(content, vocabulary) for content in pickled)
        outcomes = select_tasks(judged, opened.spec, 6, set())
        from_workers = list(islice(outcomes, 5))
        pool._workers[0].process.kill()
        from_workers += outcomes
    alone = list(generate_from_seeds(generator("behavior"), make_seeds("tasks", 1), 6, set()))
    assert sum(isinstance(outcome, GeneratedTask) for outcome in alone) == 6
    written = [
        [
            write_task_line(outcome.task, "behavior", benchmark.domain, outcome.about)
            if isinstance(outcome, GeneratedTask)
            else outcome
            for outcome in generated
        ]
        for generated in (from_workers, alone)
    ]
    assert written[0] == written[1]


def test_only_a_generator_that_can_be_opened_again_can_be_pickled() -> None:
    with pytest.raises(InputError, match="behavior: only a generator from open_generator can be pickled"):
        pickle.dumps(generator("behavior"))
