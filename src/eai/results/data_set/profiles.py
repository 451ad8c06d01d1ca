"""Profiles of tasks: the features of each, with its name and what transition modeling makes of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass

from eai.abilities.task import Task
from eai.abilities.transition_modeling.task import TransitionTask
from eai.abilities.verdict import Json
from eai.benchmark.benchmark import Benchmark
from eai.benchmark.features import FeatureBook, Features
from eai.tasks.source import Source


@dataclass(frozen=True, slots=True)
class Profile:
    """The features of a task, from its data set and its declaration alone.

    Attributes:
        task: its id.
        name: the name that tasks of a kind share.
        features: what can be counted of any task.
        operators: the distinct actions of the data set's own plan, sorted.
        scene_objects: all objects of its scene, the agent included.
        asked_operators: how many operators transition modeling asks for; None where it is not asked.
        categories: the task's categories in transition modeling, the more telling one first.
    """

    task: str
    name: str
    features: Features
    operators: tuple[str, ...]
    scene_objects: int
    asked_operators: int | None
    categories: tuple[str, ...]

    def to_json(self) -> dict[str, Json]:
        """The profile as a flat row; several words in one field are separated by spaces."""
        return {
            "task": self.task,
            "name": self.name,
            **asdict(self.features),
            "operators": " ".join(self.operators),
            "scene_objects": self.scene_objects,
            "asked_operators": self.asked_operators,
            "categories": " ".join(self.categories),
        }


def profiles_of(benchmark: Benchmark, source: Source) -> tuple[Profile, ...]:
    """The profiles of all tasks, in the order of the data set.

    Raises:
        DataError: the data cannot be had.
    """
    book, asked = FeatureBook(benchmark), benchmark.operators(source)
    return tuple(
        _profile(task, book.of(task), asked.get(task_id)) for task_id, task in benchmark.tasks(source).items()
    )


def names_of(profiles: Iterable[Profile]) -> frozenset[str]:
    """The names that tasks share."""
    return frozenset(each.name for each in profiles)


def _profile(task: Task, features: Features, asked: TransitionTask | None) -> Profile:
    return Profile(
        task=task.id,
        name=task.title,
        features=features,
        operators=tuple(sorted({action.operator for action in task.script})),
        scene_objects=len(task.scene.objects),
        asked_operators=None if asked is None else len(asked.operators),
        categories=() if asked is None else tuple(each.value for each in asked.categories),
    )
