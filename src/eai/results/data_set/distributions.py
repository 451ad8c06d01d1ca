"""Distributions of what a data set has many of: how many tasks have so many steps, goals, options.

The paper draws them for its two domains (its figures of script length, actions, objects and pairs of them, of
plan length, goals and goal options); they are counted for any benchmark.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from eai.abilities.task import Task
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.features import Features
from eai.results.data_set.profiles import profiles_of
from eai.tasks.source import Source


@dataclass(frozen=True, slots=True)
class Distribution:
    """How often each value occurs.

    Attributes:
        name: its name in files.
        title: what is counted, in words.
        of: what `counts` counts: ``tasks``, ``steps``, or ``mentions`` of objects in steps.
        counts: value -> how often, by value if values are numbers, else the most frequent first.
        decades: whether the numbers are so unlike that only their decade (1 to 9, 10 to 99, ...) tells.
    """

    name: str
    title: str
    of: str
    counts: Mapping[int, int] | Mapping[str, int]
    decades: bool = False


def distributions(benchmark: Benchmark, source: Source) -> tuple[Distribution, ...]:
    """The distributions of a benchmark, over its tasks with goals; those without any case are left out.

    Raises:
        DataError: the data cannot be had.
    """
    tasks = benchmark.tasks(source)
    asked = [each for each in profiles_of(benchmark, source) if each.features.goals]
    found = (
        *_of_features([each.features for each in asked]),
        *_of_steps(tasks[each.task] for each in asked),
    )
    return tuple(each for each in found if each.counts)


def _of_features(features: list[Features]) -> Iterator[Distribution]:
    lengths = (each.annotated_steps for each in features if each.annotated_steps)
    yield Distribution("annotated_steps", "Steps of the annotated plan", "tasks", _sorted(lengths))
    yield Distribution("goals", "Goals (conjuncts)", "tasks", _sorted(each.goals for each in features))
    ground = _sorted(each.ground_goals for each in features)
    yield Distribution("ground_goals", "Ground goals", "tasks", ground)
    options = _sorted(each.goal_options for each in features)
    yield Distribution("goal_options", "Ways to meet the goals", "tasks", options, decades=True)
    objects = _sorted(each.objects for each in features)
    yield Distribution("objects", "Objects the task is about", "tasks", objects)


def _of_steps(tasks: Iterable[Task]) -> Iterator[Distribution]:
    """The actions of annotated plans' steps, and with what category of object."""
    actions: Counter[str] = Counter()
    objects: Counter[str] = Counter()
    pairs: Counter[str] = Counter()
    for task in tasks:
        for step in task.script:
            categories = [task.scene.objects[i].category for i in step.arguments]
            actions[step.operator] += 1
            objects.update(categories)
            pairs.update(f"{step.operator} {category}" for category in categories)
    yield Distribution("actions", "Actions of annotated plans", "steps", _ranked(actions))
    yield Distribution("categories", "Objects of those steps, by category", "mentions", _ranked(objects))
    yield Distribution("pairs", "Actions with objects", "mentions", _ranked(pairs))


def _sorted(values: Iterable[int]) -> dict[int, int]:
    return dict(sorted(Counter(values).items()))


def _ranked(counts: Mapping[str, int]) -> dict[str, int]:
    return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0])))
