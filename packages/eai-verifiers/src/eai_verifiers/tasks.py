"""Sources of tasks: a benchmark's own tasks, or an endless stream of generated ones."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.benchmarks.generator.generator import TaskGenerator, generate_from_seeds
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import GeneratedTask, PlanLengthTier, TaskSpecification, TaskSplit
from eai.benchmarks.prompt_library import PromptLibrary
from eai.benchmarks.registry import find_benchmark, make_benchmark_with_other_tasks
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.reward import open_reward_suite
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source, use_tasks
from eai.tasks.task_lines import make_task_from_line, read_task_line, write_task_line

_TASKS_PER_BATCH = 8
"""Number of generated tasks whose prompts are made together: each shows another of them as example."""

_MAX_CACHED_TASKS = 4096
"""Maximum number of generated tasks that a process keeps in its cache."""


class TaskWithPrompt(NamedTuple):
    """A task with its prompt.

    Attributes:
        task: Reference of the task, as `Suite.reference` writes it.
        line: The whole task as a line of a task file if it is generated; None for a benchmark's own task.
    """

    task: str
    prompt: Prompt
    line: str | None = None


def iterate_benchmark_tasks(domain: str, ability: Ability, prompts: PromptSet) -> Iterator[TaskWithPrompt]:
    """Yield the tasks of a benchmark for an ability, in the order of the data set."""
    suite = open_reward_suite(domain, ability)
    prompts_by_task = PromptLibrary(prompts, None, suite.source).open(suite.benchmark, ability)
    for task_id in suite.task_ids:
        yield TaskWithPrompt(suite.reference(task_id), prompts_by_task[task_id])


def generate_tasks(
    domain: str, ability: Ability, split: TaskSplit, seed: int, tier: PlanLengthTier
) -> Iterator[TaskWithPrompt]:
    """Yield new tasks in the world of a benchmark without end. Equal seeds give equal tasks.

    Two splits have no goals in common. A plan of one split may still solve a task of another split: an
    endless stream cannot be checked for this.
    """
    base, source = find_benchmark(domain), Source(planner=PlannerChoice.NONE)
    spec = TaskSpecification(domain, base.tasks(source).sha256, tier, split=split)
    attempts = generate_from_seeds(
        TaskGenerator(base, spec, source), make_seeds(split.value, seed), sys.maxsize, set()
    )
    generated_tasks = (generated for generated in attempts if isinstance(generated, GeneratedTask))
    while batch := list(islice(generated_tasks, _TASKS_PER_BATCH)):
        prompts_by_task = PromptLibrary("eai", None, source).open(
            make_benchmark_with_other_tasks(
                base, split.value, use_tasks(*[generated.task for generated in batch])
            ),
            ability,
        )
        for generated in batch:
            line = write_task_line(generated.task, domain, base.domain, generated.about)
            yield TaskWithPrompt(
                f"{domain}/{ability.value}/{generated.task.id}", prompts_by_task[generated.task.id], line
            )


@lru_cache(_MAX_CACHED_TASKS)
def make_single_task_suite(line: str, ability: Ability) -> Suite:
    """Return the suite of one task from its line of a task file.

    Raises:
        InputError: The line is not a task.
    """
    line_content = read_task_line(line)
    base = find_benchmark(line_content.base)
    benchmark = make_benchmark_with_other_tasks(
        base, "generated", use_tasks(make_task_from_line(line_content, base.domain))
    )
    return open_suite(benchmark, ability, source=Source(planner=PlannerChoice.NONE))
