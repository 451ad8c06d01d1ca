"""Official questions about operators, made to ask for those that are scored."""

from __future__ import annotations

from eai.abilities.transition_modeling.task import TransitionTask

_BEFORE, _BEHIND = "Action to be finished:\n", "\nOutput:"


def asking_for_scored(task: TransitionTask, question: str) -> str:
    """The question with the heads of the operators of its task in the place of those that it asks for."""
    before, mark, rest = question.rpartition(_BEFORE)
    _, end, behind = rest.partition(_BEHIND)
    return "".join((before, mark, *(_head(task, name) for name in task.operators), end, behind))


def _head(task: TransitionTask, name: str) -> str:
    """An operator to be finished as the other questions have it, the bracket behind its name included."""
    parameters = task.domain.operators[name].parameters
    return f"(:action {name})\n:parameters {parameters}\n:precondition ()\n:effect ()\n)\n"
