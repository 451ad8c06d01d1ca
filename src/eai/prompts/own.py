"""Our own prompts, rendered from a domain's declaration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from eai.abilities.protocol import Ability
from eai.abilities.task import Task
from eai.prompts.prompt import Prompt
from eai.prompts.template import Templates
from eai.prompts.wording import Wording

Example: TypeAlias = Callable[[str], str]
"""The data set's own answer to a task, by id."""


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
