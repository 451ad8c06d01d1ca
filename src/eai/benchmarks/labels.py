"""Derive labels of tasks from goals, so that results of different suites can be compared by kind of task.

The labels (such as ``transport``), and the rules for BEHAVIOR-1K, are those of EAI v2's taxonomy (version 7).
One rule differs: if a goal is to make an object, the task gets the label ``cutting`` only for halves and
diced objects. The rules for other benchmarks are ours. For example, a goal about the place of VirtualHome's
agent moves no object.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from eai.logic.formula import Atom, Exactly, ForPairs, Occurs, Then, Until, Variable
from eai.logic.traversal import get_bound_variables, walk_subformulas
from eai.tasks.task import Task

_MIN_COMPOSITE_GOALS = 3
_MIN_ACTIVITY_GOALS = 6


def derive_task_labels_from_goals(
    task: Task, labels_by_predicate_or_action: Mapping[str, str]
) -> tuple[str, ...]:
    """Return the sorted labels of a task, or no labels if it has no goals.

    Args:
        task: the task.
        labels_by_predicate_or_action: goal predicate or action -> labels (field `labels` of
            `eai.benchmarks.benchmark.DataSet`).
    """
    labels = {
        label
        for goal_key in _yield_goal_predicates_with_categories(task)
        for label in _find_labels_of_goal_predicate(goal_key, labels_by_predicate_or_action)
    }
    parts = [part for goal in task.goals for part in walk_subformulas(goal.formula)]
    if any(isinstance(part, (Exactly, ForPairs)) for part in parts):
        labels.add("quantified-goal")
    if any(isinstance(part, (Then, Until)) for part in parts):
        labels.add("ordered")
    if task.goals:
        labels.add(_make_task_horizon_label(len(task.goals)))
    return tuple(sorted(labels))


def _make_task_horizon_label(goal_count: int) -> str:
    if goal_count < _MIN_COMPOSITE_GOALS:
        return "horizon-atomic"
    return "horizon-composite" if goal_count < _MIN_ACTIVITY_GOALS else "horizon-activity"


def _yield_goal_predicates_with_categories(task: Task) -> Iterator[tuple[str, str]]:
    """Yield each predicate or action of the goals with the category of its first argument, or with ""."""
    scene = task.scene
    for goal in task.goals:
        parts = list(walk_subformulas(goal.formula))
        categories = {bound.name: bound.category for part in parts for bound in get_bound_variables(part)}
        for part in parts:
            match part:
                case Atom(name, arguments) | Occurs(name, arguments):
                    first = next(iter(arguments), None)
                    if isinstance(first, Variable):
                        yield name, categories.get(first.name) or ""
                    else:
                        index = None if first is None else scene.index.get(first.name)
                        yield name, "" if index is None else scene.objects[index].category


def _find_labels_of_goal_predicate(
    predicate_and_category: tuple[str, str], labels_by_predicate_or_action: Mapping[str, str]
) -> list[str]:
    name, category = predicate_and_category
    keys = [*(f"{name} {word}" for word in category.split("__")), name]
    return next(
        (labels_by_predicate_or_action[key].split() for key in keys if key in labels_by_predicate_or_action),
        [],
    )
