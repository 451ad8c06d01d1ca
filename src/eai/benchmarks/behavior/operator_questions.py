"""BEHAVIOR's official questions about operators, made to ask for those that are scored.

As they are shipped, 25 of the 100 ask for others: 22 for ``place_nextto`` where ``release`` is scored (one
of them without ``open`` besides), one without ``release``, one without ``place_onfloor``, and one for
``open`` and ``place_inside``, which are not scored. The published models were asked for the scored ones: 218
of 225 answers of nine models to these tasks write exactly those.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from eai.abilities.transition_modeling.task import TransitionTask
from eai.benchmarks.gold_operators import open_behavior
from eai.benchmarks.published_prompts import Correct
from eai.data.progress import Report
from eai.data.store import Store

_BEFORE, _BEHIND = "Action to be finished:\n", "\nOutput:"
_NAME = re.compile(r"\(:action ([^\s()]+)")


def corrected_questions(store: Store | None, report: Report) -> Correct:
    """What gives the question of a task, which is the shipped one where that asks for what is scored.

    Raises:
        DataError: the operators cannot be obtained.
    """
    tasks: Mapping[str, TransitionTask] = open_behavior(store, report=report)
    return lambda task_id, question: _corrected(tasks[task_id], question)


def _corrected(task: TransitionTask, question: str) -> str:
    before, mark, rest = question.rpartition(_BEFORE)
    asked, end, behind = rest.partition(_BEHIND)
    if set(_NAME.findall(asked)) == set(task.operators):
        return question
    return "".join((before, mark, *(_head(task, name) for name in task.operators), end, behind))


def _head(task: TransitionTask, name: str) -> str:
    """An operator to be finished as the other questions have it, the bracket behind its name included."""
    parameters = task.domain.operators[name].parameters
    return f"(:action {name})\n:parameters {parameters}\n:precondition ()\n:effect ()\n)\n"
