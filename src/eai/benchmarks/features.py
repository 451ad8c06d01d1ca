"""Features of tasks: what each is like, whatever is answered, from its data set and its declaration alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import prod

from eai.abilities.goal_interpretation.lexicon import GoalLexicon
from eai.abilities.goal_test import GoalTest
from eai.abilities.task import GoalKind, Task
from eai.abilities.transition_modeling.task import TransitionTask
from eai.abilities.verdict import Json
from eai.benchmarks.benchmark import Benchmark
from eai.benchmarks.source import Source
from eai.logic.formula import Exactly, Exists, ForAll, Formula, ForPairs
from eai.logic.options import choice_options, count_choice_options
from eai.logic.traversal import walk

_QUANTIFIERS = (ForAll, Exists, Exactly, ForPairs)


@dataclass(frozen=True, slots=True)
class Features:
    """What a task is like. The goals of a task are *conditions*, which may speak of objects in general.

    They are *ground* where it is said which objects are meant: the first way to meet each, as goal
    interpretation asks for it.

    Attributes:
        task: its id.
        name: the name that tasks of a kind share.
        plan_steps: how many steps the data set's own plan has; None if it has none.
        operators: the distinct actions of that plan, sorted.
        conditions: its goals.
        state_conditions: those of single objects.
        relation_conditions: those that speak of any relation.
        action_conditions: those of actions to be taken.
        quantified: those that speak of objects in general.
        true_at_start: those that hold before anything is done.
        ground_goals: ground conditions.
        ground_states: those of one object.
        ground_relations: those of two objects.
        ground_actions: those of an action.
        options: in how many ways the goals can be met.
        objects: the objects that the task is about, the agent not counted.
        object_categories: how many categories these have.
        scene_objects: all objects of its scene, the agent included.
        instruction_words: words of the instruction.
        asked_operators: how many operators transition modeling asks for; None where it is not asked.
        categories: the categories of the task in transition modeling, the more telling one first.
    """

    task: str
    name: str
    plan_steps: int | None
    operators: tuple[str, ...]
    conditions: int
    state_conditions: int
    relation_conditions: int
    action_conditions: int
    quantified: int
    true_at_start: int
    ground_goals: int
    ground_states: int
    ground_relations: int
    ground_actions: int
    options: int
    objects: int
    object_categories: int
    scene_objects: int
    instruction_words: int
    asked_operators: int | None
    categories: tuple[str, ...]

    def to_json(self) -> dict[str, Json]:
        """The features as a flat row; several words in one field are separated by spaces."""
        row: dict[str, Json] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            row[field.name] = " ".join(value) if isinstance(value, tuple) else value
        return row


def features_of(benchmark: Benchmark, source: Source) -> dict[str, Features]:
    """Task id -> features, in the order of the data set.

    Raises:
        DataError: the data cannot be had.
    """
    asked = benchmark.operators(source)
    return {
        task_id: _features(benchmark, task, asked.get(task_id))
        for task_id, task in benchmark.tasks(source).items()
    }


def _features(benchmark: Benchmark, task: Task, asked: TransitionTask | None) -> Features:
    lexicon = GoalLexicon(task, benchmark.domain, benchmark.goals)
    choices = [each.options for each in benchmark.goals.alternatives(task)]
    ground = Counter(
        lexicon.kind(lexicon.spelt(literal))
        for choice in choices
        for literal in next(choice_options(choice), ())
    )
    kinds = Counter(goal.kind for goal in task.goals)
    relevant = [task.scene.objects[i] for i in task.relevant if i != task.scene.agent]
    return Features(
        task=task.id,
        name=task.title,
        plan_steps=len(task.script) or None,
        operators=tuple(sorted({action.operator for action in task.script})),
        conditions=len(task.goals),
        state_conditions=kinds[GoalKind.STATE],
        relation_conditions=kinds[GoalKind.RELATION],
        action_conditions=kinds[GoalKind.ACTION],
        quantified=sum(_is_quantified(goal.formula) for goal in task.goals),
        true_at_start=sum(GoalTest(task).reached(task.initial, ())),
        ground_goals=ground.total(),
        ground_states=ground[GoalKind.STATE],
        ground_relations=ground[GoalKind.RELATION],
        ground_actions=ground[GoalKind.ACTION],
        options=prod(map(count_choice_options, choices)),
        objects=len(relevant),
        object_categories=len({thing.category for thing in relevant}),
        scene_objects=len(task.scene.objects),
        instruction_words=len(task.instruction.split()),
        asked_operators=None if asked is None else len(asked.operators),
        categories=() if asked is None else tuple(each.value for each in asked.categories),
    )


def _is_quantified(formula: Formula) -> bool:
    return any(isinstance(part, _QUANTIFIERS) for part in walk(formula))


def by_name(features: Mapping[str, Features]) -> dict[str, list[Features]]:
    """The features of the tasks of each name, in order of first mention."""
    found: dict[str, list[Features]] = {}
    for each in features.values():
        found.setdefault(each.name, []).append(each)
    return found
