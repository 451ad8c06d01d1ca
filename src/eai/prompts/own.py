"""Our own prompts, rendered from a domain's declaration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from eai.abilities.protocol import Ability, Domain
from eai.abilities.task import Task
from eai.benchmarks import gold_operators
from eai.benchmarks.behavior import domain as behavior
from eai.benchmarks.behavior import tasks as behavior_tasks
from eai.benchmarks.behavior.predicates import GOAL_RELATIONS, GOAL_STATES
from eai.benchmarks.behavior.tasks import BehaviorTask
from eai.benchmarks.virtualhome import domain as virtualhome
from eai.benchmarks.virtualhome import tasks as virtualhome_tasks
from eai.data.progress import Report, silent
from eai.data.store import Store
from eai.prompts.operators import operator_prompts
from eai.prompts.prompt import Prompt
from eai.prompts.template import Templates
from eai.prompts.wording import ObjectName, Wording, declared_name

Example: TypeAlias = Callable[[str], str]
"""The data set's own answer to a task, by id."""

Examples: TypeAlias = Callable[[Domain, Ability], Example]
"""The data set's own answers of a suite."""

_RELATION_NAMES = {predicate: name for name, predicate in virtualhome_tasks.PREDICATE_OF_RELATION.items()}
_HANDS = {"in_right_hand": "holds_rh", "in_left_hand": "holds_lh"}


@dataclass(frozen=True, slots=True)
class Questions:
    """What prompts of one ability are rendered from; any declared domain will do.

    Attributes:
        ability: the ability; transition modeling is rendered by `operator_prompts`.
        wording: the words of the declaration.
        tasks: the tasks by id.
        answer_format: how an answer is written.
        example: a good answer to each task.
    """

    ability: Ability
    wording: Wording
    tasks: Mapping[str, Task]
    answer_format: str
    example: Example


def own_prompts(
    domain: Domain,
    ability: Ability,
    example: Example,
    store: Store | None = None,
    *,
    folder: Path | None = None,
    report: Report = silent,
) -> Mapping[str, Prompt]:
    """Our prompts of a suite by task id, in the order of the data set.

    Args:
        domain: the domain.
        ability: the ability.
        example: the data set's own answers.
        store: where the data set is; the user's default store if None.
        folder: the user's own templates, in place of ours of the same name.
        report: told of a download.

    Raises:
        DataError: the data cannot be obtained.
        InputError: a template of the user's cannot be used.
    """
    templates = Templates(folder)
    is_virtualhome = domain is Domain.VIRTUALHOME
    if ability is Ability.TRANSITION_MODELING:
        open_operators = gold_operators.open_virtualhome if is_virtualhome else gold_operators.open_behavior
        return operator_prompts(open_operators(store, report=report), templates)
    tasks: Mapping[str, Task] = (
        virtualhome_tasks.open_tasks(store, report=report)
        if is_virtualhome
        else behavior_tasks.open_tasks(store, report=report)
    )
    if is_virtualhome and ability is Ability.SUBGOAL_DECOMPOSITION:
        tasks = {task_id: task for task_id, task in tasks.items() if task.temporal_goal is not None}
    wording = virtualhome_wording(ability) if is_virtualhome else behavior_wording(ability)
    answer_format = templates.text(f"formats/{domain.value}_{ability.value}.txt")
    return render(Questions(ability, wording, tasks, answer_format, example), templates)


def render(questions: Questions, templates: Templates) -> dict[str, Prompt]:
    """The prompt of every task, by id. Each shows as example the first task that has another title."""
    name, wording = questions.ability.value, questions.wording
    shared = {
        "vocabulary": wording.vocabulary(),
        "operators": wording.operators(),
        "format": questions.answer_format,
    }
    texts = {
        task_id: templates.fill(f"{name}_task.txt", _values(wording, task))
        for task_id, task in questions.tasks.items()
    }
    examples = {
        title: _example_for(title, questions) for title in {t.title for t in questions.tasks.values()}
    }
    prompts = {}
    for task_id, task in questions.tasks.items():
        other = examples[task.title]
        example = ""
        if other is not None:
            answer = questions.example(other)
            example = templates.fill("example.txt", {"task": texts[other], "answer": answer})
        values = {**shared, "example": example, "task": texts[task_id]}
        prompts[task_id] = Prompt(templates.fill(f"{name}.txt", values))
    return prompts


def _example_for(title: str, questions: Questions) -> str | None:
    return next((task_id for task_id, task in questions.tasks.items() if task.title != title), None)


def _values(wording: Wording, task: Task) -> dict[str, str]:
    return {
        "title": task.title,
        "instruction": task.instruction,
        "objects": wording.objects(task),
        "initial": wording.initial(task),
        "goals": wording.goals(task),
    }


def virtualhome_wording(ability: Ability) -> Wording:
    """VirtualHome's words: goal interpretation speaks of classes, and names relations as scene graphs do."""
    wording = Wording.of(virtualhome.as_meant())
    if ability is not Ability.GOAL_INTERPRETATION:
        return wording
    return Wording(wording.domain, wording.predicates, _RELATION_NAMES, _class_name)


def behavior_wording(ability: Ability) -> Wording:
    """BEHAVIOR's words: goals are made of what is seen of objects, not of how the simulator stores it."""
    goal_predicates = (*(state.name for state in GOAL_STATES), *(each.name for each in GOAL_RELATIONS))
    if ability is Ability.SUBGOAL_DECOMPOSITION:
        written_as = {**_HANDS, "toggled_on": "toggledon"}
        return Wording(behavior.as_meant(), (*goal_predicates, *_HANDS), written_as, _dotted_name)
    names: ObjectName = _instance_name if ability is Ability.GOAL_INTERPRETATION else declared_name
    return Wording(behavior.as_meant(), goal_predicates, {}, names)


def _class_name(task: Task, index: int) -> str:
    return task.scene.objects[index].category


def _dotted_name(task: Task, index: int) -> str:
    """``rag_51`` as subgoals write it: ``rag.51``."""
    return ".".join(declared_name(task, index).rsplit("_", 1))


def _instance_name(task: Task, index: int) -> str:
    """The name of an object in its problem file: ``rag.n.01_1``."""
    name = declared_name(task, index)
    if not isinstance(task, BehaviorTask):
        return name
    return next((thing.instance for thing in task.record.objects if thing.name == name), name)
