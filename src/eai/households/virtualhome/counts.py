"""What is counted in VirtualHome's records as they are annotated, duplicates and all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable

from eai.benchmark.figure import Figure
from eai.households.packs import RESOURCES, open_published, open_virtualhome
from eai.households.virtualhome.pack import VirtualHome
from eai.households.virtualhome.records import TaskRecord
from eai.tasks.source import Source


def annotated_figures(source: Source) -> tuple[Figure, ...]:
    """The figures of the published data set; DataError if it cannot be had."""
    resources = open_published(RESOURCES, source.store, report=source.report)
    tasks = open_virtualhome(source.store, report=source.report)
    operators = resources.read_json("gold_action.json")
    return count_annotated(tasks, resources.read_json("success_task.json"), len(operators))


def count_annotated(
    tasks: VirtualHome, transition_tasks: Collection[str], operators: int
) -> tuple[Figure, ...]:
    """The figures of records.

    Args:
        tasks: all tasks.
        transition_tasks: ids of the tasks of transition modeling.
        operators: number of annotated operators.
    """
    records = tuple(tasks.values())
    instructed = [task for task in records if has_goals(task)]
    lost = [task for task in records if len(set(task.edge_goals)) > 1]
    state, relation, action = (
        sum(len(task.node_goals) for task in records),
        sum(len(task.edge_goals) for task in records),
        sum(len(task.action_goals) for task in records),
    )
    return (
        Figure("task names", len({task.title for task in records}), "distinct names that tasks share"),
        Figure("tasks", len(records), "annotated; the denominator of goal interpretation"),
        Figure(
            "instructions",
            len(instructed),
            f"tasks that have a goal; {len(records) - len(instructed)} have none",
        ),
        Figure(
            "action sequencing tasks",
            len(records) - len(lost),
            f"under protocol eai-1.0.5: tasks less the {len(lost)} with two or more distinct relation goals, "
            "which the reference drops",
        ),
        Figure("transition modeling tasks", len(transition_tasks), _left_out(instructed, transition_tasks)),
        Figure("goals", state + relation + action, "of all tasks, as annotated, duplicates included"),
        Figure("state goals", state, "an object is in a state"),
        Figure("relation goals", relation, "two objects stand in a relation"),
        Figure("action goals", action, "an action was done, possibly one of several alternatives"),
        Figure("action steps", sum(len(task.script) for task in instructed), "of the annotated scripts"),
        Figure("transition models", operators, "annotated operators"),
    )


def _left_out(instructed: Iterable[TaskRecord], transition_tasks: Collection[str]) -> str:
    titles = Counter(task.title for task in instructed if task.id not in transition_tasks)
    names = ", ".join(f"{title} ({count})" for title, count in titles.most_common())
    return f"instructions less those the reference leaves out: {names or 'none'}"


def has_goals(task: TaskRecord) -> bool:
    """Does the task ask for anything?"""
    return bool(task.node_goals or task.edge_goals or task.action_goals)
