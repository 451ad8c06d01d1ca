"""Where tasks come from: a benchmark's own, or new ones without end."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

from eai.abilities.protocol import Ability
from eai.benchmarks.generator.generator import Generator, generate
from eai.benchmarks.generator.sets import make_seeds
from eai.benchmarks.generator.spec import Generated, Spec, Split, Tier
from eai.benchmarks.prompt_library import Library
from eai.benchmarks.registry import find_benchmark, replace_tasks
from eai.benchmarks.suite import Suite, open_suite
from eai.pddl.planning import PlannerChoice
from eai.results.reward import open_reward_suite
from eai.tasks.prompts.prompt import Prompt, PromptSet
from eai.tasks.source import Source, given
from eai.tasks.task_lines import read_line, task_from_line, write_task_line

_TOGETHER = 8
"""How many new tasks are asked about together: prompts show another of them as example."""

_KEPT = 4096
"""How many new tasks are kept ready in a process."""


class Asked(NamedTuple):
    """A task with its prompt.

    Attributes:
        task: its name, as `Suite.reference` writes it.
        line: all of it, as task files have it, if there is no other place to find it; else None.
    """

    task: str
    prompt: Prompt
    line: str | None = None


def own_tasks(domain: str, ability: Ability, prompts: PromptSet) -> Iterator[Asked]:
    """The tasks of a benchmark in which an ability is asked for, in the order of the data set."""
    suite = open_reward_suite(domain, ability)
    asked = Library(prompts, None, suite.source).open(suite.benchmark, ability)
    for task_id in suite.task_ids:
        yield Asked(suite.reference(task_id), asked[task_id])


def new_tasks(domain: str, ability: Ability, split: Split, seed: int, tier: Tier) -> Iterator[Asked]:
    """Tasks in the world of a benchmark that nobody has seen, without end; of equal seeds the same ones.

    Two splits have no goals in common. What the plan of a task of another split solves is not left out: of
    tasks without end nobody knows all.
    """
    base, source = find_benchmark(domain), Source(planner=PlannerChoice.NONE)
    spec = Spec(domain, base.tasks(source).sha256, tier, split=split)
    made = generate(Generator(base, spec, source), make_seeds(split.value, seed), sys.maxsize, set())
    found = (each for each in made if isinstance(each, Generated))
    while batch := list(islice(found, _TOGETHER)):
        asked = Library("eai", None, source).open(
            replace_tasks(base, split.value, given(*[each.task for each in batch])), ability
        )
        for each in batch:
            line = write_task_line(each.task, domain, base.domain, each.about)
            yield Asked(f"{domain}/{ability.value}/{each.task.id}", asked[each.task.id], line)


@lru_cache(_KEPT)
def suite_of_one(line: str, ability: Ability) -> Suite:
    """The suite of one task, as a task file has it.

    Raises:
        InputError: it is no task.
    """
    read = read_line(line)
    base = find_benchmark(read.base)
    made = replace_tasks(base, "generated", given(task_from_line(read, base.domain)))
    return open_suite(made, ability, source=Source(planner=PlannerChoice.NONE))
