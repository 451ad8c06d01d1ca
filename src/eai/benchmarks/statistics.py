"""The paper's Table 2, counted from the data: one table a domain, each figure with what it counts.

Published tables use four different numbers of tasks; the rows say which ability uses which, and why.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from math import prod
from statistics import fmean

from eai.benchmarks.behavior.records import PACK as BEHAVIOR
from eai.benchmarks.behavior.records import Behavior, BehaviorRecord, Condition
from eai.benchmarks.packs import BEHAVIOR_PDDL, RESOURCES, open_published, open_virtualhome
from eai.benchmarks.virtualhome.pack import VirtualHome
from eai.benchmarks.virtualhome.records import TaskRecord
from eai.data.store import Store
from eai.logic.options import count_options


@dataclass(frozen=True, slots=True)
class StatRow:
    """One figure; `note` says what exactly is counted."""

    label: str
    value: int | float
    note: str


@dataclass(frozen=True, slots=True)
class StatTable:
    """The figures of one domain, in the paper's order."""

    domain: str
    rows: tuple[StatRow, ...]


def stats(store: Store | None = None) -> tuple[StatTable, ...]:
    """The tables of all domains, from the store; absent packs are fetched first.

    Raises:
        DataError: the data cannot be obtained or is damaged.
    """
    return tuple(count(store or Store()) for count in _COUNTERS)


def virtualhome_table(store: Store) -> StatTable:
    """VirtualHome's column; DataError as in `stats`."""
    tasks = open_virtualhome(store)
    resources = open_published(RESOURCES, store)
    transition_tasks = resources.read_json("success_task.json")
    operators = resources.read_json("gold_action.json")
    return StatTable("virtualhome", virtualhome_rows(tasks, transition_tasks, len(operators)))


def virtualhome_rows(
    tasks: VirtualHome, transition_tasks: Collection[str], operators: int
) -> tuple[StatRow, ...]:
    """The figures of VirtualHome.

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
    steps = [len(task.script) for task in instructed]
    return (
        StatRow("task names", len({task.title for task in records}), "distinct names that tasks share"),
        StatRow("tasks", len(records), "annotated; the denominator of goal interpretation"),
        StatRow(
            "instructions",
            len(instructed),
            f"tasks less the {len(records) - len(instructed)} without any goal; the denominator of "
            "subgoal decomposition",
        ),
        StatRow(
            "action sequencing tasks",
            len(records) - len(lost),
            f"under protocol eai-1.0.5: tasks less the {len(lost)} with two or more distinct relation goals, "
            "which the reference drops",
        ),
        StatRow("transition modeling tasks", len(transition_tasks), _left_out(instructed, transition_tasks)),
        StatRow("goals", state + relation + action, "of all tasks, as annotated, duplicates included"),
        StatRow("state goals", state, "an object is in a state"),
        StatRow("relation goals", relation, "two objects stand in a relation"),
        StatRow("action goals", action, "an action was done, possibly one of several alternatives"),
        StatRow("trajectories", len(instructed), "annotated scripts of the instructions"),
        StatRow("action steps", sum(steps), "of those scripts"),
        StatRow("steps per trajectory", round(fmean(steps), 2), f"{sum(steps)} steps / {len(steps)} scripts"),
        StatRow("transition models", operators, "annotated operators"),
    )


def _left_out(instructed: Iterable[TaskRecord], transition_tasks: Collection[str]) -> str:
    titles = Counter(task.title for task in instructed if task.id not in transition_tasks)
    names = ", ".join(f"{title} ({count})" for title, count in titles.most_common())
    return f"instructions less those the reference leaves out: {names or 'none'}"


def has_goals(task: TaskRecord) -> bool:
    """Does the task ask for anything?"""
    return bool(task.node_goals or task.edge_goals or task.action_goals)


def behavior_table(store: Store) -> StatTable:
    """BEHAVIOR's column; DataError as in `stats`."""
    tasks = Behavior(open_published(BEHAVIOR, store))
    operators = open_published(BEHAVIOR_PDDL, store).read_json("gold_action.json")
    return StatTable("behavior", behavior_rows(tasks, len(operators)))


def behavior_rows(tasks: Behavior, operators: int) -> tuple[StatRow, ...]:
    """The figures of BEHAVIOR.

    Args:
        tasks: all tasks.
        operators: number of annotated operators.
    """
    records = tuple(tasks.values())
    conditions = Counter(
        _arguments(condition)
        for record in records
        for goal in tasks.goal_options(record.id)
        for condition in goal[0]
    )
    ways = [
        prod(count_options(goal, _Declared(record)) for goal in record.problem.goals) for record in records
    ]
    steps = [len(record.plan) for record in records]
    first = "in the first ground option of each goal"
    return (
        StatRow("task names", len({record.activity for record in records}), "distinct activities"),
        StatRow("instructions", len(records), "tasks; the denominator of every ability"),
        StatRow(
            "goals", conditions.total(), f"ground conditions {first}, as goal interpretation counts them"
        ),
        StatRow("state goals", conditions[1], f"of one object, {first}"),
        StatRow("relation goals", conditions[2], f"of two objects, {first}"),
        StatRow("action goals", 0, "BEHAVIOR has none"),
        StatRow(
            "goals per task", round(conditions.total() / len(records), 2), f"{conditions.total()} conditions"
        ),
        StatRow(
            "goal conditions",
            sum(len(record.problem.goals) for record in records),
            "conjuncts of the problems' goals, as action sequencing and subgoal decomposition count them",
        ),
        StatRow(
            "goal options per task",
            round(fmean(ways), 2),
            "ways to choose a ground option for each goal, counted without listing them",
        ),
        StatRow("trajectories", len(records), "annotated plans"),
        StatRow("action steps", sum(steps), "of those plans as released; the paper counts 1,460"),
        StatRow("steps per trajectory", round(fmean(steps), 2), f"{sum(steps)} steps / {len(steps)} plans"),
        StatRow("transition models", operators, "annotated operators"),
    )


def _arguments(condition: Condition) -> int:
    """The number of objects of a condition or of its negation."""
    inner = condition[1] if condition[0] == "not" else condition
    return len(inner) - 1


@dataclass(frozen=True, slots=True)
class _Declared:
    """The objects of a task by the category that its problem declares them with."""

    record: BehaviorRecord

    def objects(self, category: str | None) -> Sequence[str]:
        """The instances of a category, in the order of the problem."""
        things = self.record.objects
        return [thing.instance for thing in things if category is None or thing.category == category]


_COUNTERS: tuple[Callable[[Store], StatTable], ...] = (virtualhome_table, behavior_table)
