"""Prompts of transition modeling: the heads of operators, to be completed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from eai.abilities.transition_modeling.task import TransitionTask
from eai.pddl.writer import write_domain
from eai.prompts.prompt import Prompt
from eai.prompts.template import Templates


def operator_prompts(tasks: Mapping[str, TransitionTask], templates: Templates) -> dict[str, Prompt]:
    """The prompt of every task, by id. The example shows operators that the task does not ask for.

    Raises:
        InputError: a template of the user's cannot be used.
    """
    answer_format = templates.text("formats/transition_modeling.txt")
    prompts = {}
    for task_id, task in tasks.items():
        values = {
            "predicates": write_domain(task.domain.header),
            "format": answer_format,
            "example": _example(task, tasks, templates),
            "task": _question(task, task.operators, templates),
        }
        prompts[task_id] = Prompt(templates.fill("transition_modeling.txt", values))
    return prompts


def _question(task: TransitionTask, operators: Sequence[str], templates: Templates) -> str:
    heads = "\n".join(
        f"(:action {name}\n  :parameters {task.domain.operators[name].parameters}\n"
        "  :precondition ()\n  :effect ())"
        for name in operators
    )
    values = {"problem": task.problem_text.strip(), "heads": heads}
    return templates.fill("transition_modeling_task.txt", values)


def _example(task: TransitionTask, tasks: Mapping[str, TransitionTask], templates: Templates) -> str:
    """The other task with the most operators that this one does not ask for, and only these of it."""
    asked = set(task.operators)
    best = max(tasks.values(), key=lambda other: len(set(other.operators) - asked))
    operators = [name for name in best.operators if name not in asked]
    if not operators:
        return ""
    answer = json.dumps({"output": "\n".join(task.domain.operators[name].pddl for name in operators)})
    return templates.fill("example.txt", {"task": _question(best, operators, templates), "answer": answer})
