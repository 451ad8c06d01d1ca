"""Make tasks from seeds (random texts) in worker processes, for the process that chooses among the tasks."""

from __future__ import annotations

import io
import pickle
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path

from eai.base.store import ignore_progress
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.generator import sets
from eai.benchmarks.generator.generator import TaskGenerator
from eai.benchmarks.generator.seeds import TaskSeedOutcome
from eai.benchmarks.generator.spec import GeneratedTask, TaskSpecification
from eai.benchmarks.registry import find_benchmark
from eai.tasks.source import Source
from eai.world.vocabulary import Vocabulary


def open_generator(
    spec: TaskSpecification,
    source: Source,
    earlier_split_files: tuple[Path, ...] = (),
    later_split_files: tuple[Path, ...] = (),
) -> TaskGenerator:
    """Return a task generator that can be pickled: another process opens the benchmark and files again.

    Args:
        spec: the specification of the tasks.
        source: the source of the benchmark's data.
        earlier_split_files: task files of the splits, such as the training set, that precede the tasks'
            split.
        later_split_files: task files of the splits that follow the tasks' split.

    Raises:
        InputError: a line of a file is not a task, or the benchmark cannot meet the specification.
    """
    benchmark, source = find_benchmark(spec.like), replace(source, report=ignore_progress)
    known, held_out = (
        chain.from_iterable(sets.read_tasks_of_set(file, benchmark.domain) for file in files)
        for files in (earlier_split_files, later_split_files)
    )
    is_given_away = sets.make_shared_plan_detector(benchmark.domain, known, held_out)
    reopen = partial(open_generator, spec, source, earlier_split_files, later_split_files)
    return TaskGenerator(benchmark, spec, source, is_given_away, reopen)


def make_tasks_from_seed_batch(
    add_reference_plans: Callable[[GeneratedTask, Benchmark], GeneratedTask],
    generator: TaskGenerator,
    seeds: Sequence[str],
) -> list[bytes]:
    """Return, for each seed, its task or the reason why it gives no task, pickled.

    `unpickle_task_generation_outcome` unpickles them.

    Args:
        add_reference_plans: given a generated task and its benchmark, adds a shortest plan, and a reference
            plan for an agent that sees only a part of the world.
        generator: the generator.
        seeds: the seeds.
    """
    benchmark = generator.benchmark
    results = [generator.make_task_from_seed(seed) for seed in seeds]
    completed = [
        replace(each, outcome=add_reference_plans(each.outcome, benchmark))
        if isinstance(each.outcome, GeneratedTask)
        else each
        for each in results
    ]
    return [_dump_seed_result(each, benchmark.domain.vocabulary) for each in completed]


class _TaskPickler(pickle.Pickler):
    """Pickles tasks without their vocabulary, whose functions cannot be pickled."""

    def __init__(self, file: io.BytesIO, vocabulary: Vocabulary) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._vocabulary = vocabulary

    def persistent_id(self, value: object) -> str | None:
        return "vocabulary" if value is self._vocabulary else None


class _TaskUnpickler(pickle.Unpickler):
    """Reads tasks that `_TaskPickler` pickled."""

    def __init__(self, file: io.BytesIO, vocabulary: Vocabulary) -> None:
        super().__init__(file)
        self._vocabulary = vocabulary

    def persistent_load(self, name: str) -> Vocabulary:
        return self._vocabulary


def _dump_seed_result(result: TaskSeedOutcome, vocabulary: Vocabulary) -> bytes:
    file = io.BytesIO()
    _TaskPickler(file, vocabulary).dump(result)
    return file.getvalue()


def unpickle_task_generation_outcome(pickled_outcome: bytes, vocabulary: Vocabulary) -> TaskSeedOutcome:
    """Return the task of a seed, or why it gives none, as pickled by `make_tasks_from_seed_batch`.

    Args:
        pickled_outcome: the pickled `TaskSeedOutcome`.
        vocabulary: the vocabulary of the benchmark.
    """
    result: TaskSeedOutcome = _TaskUnpickler(io.BytesIO(pickled_outcome), vocabulary).load()
    return result
