"""Gold operators in the form of answers."""

from __future__ import annotations

from eai.benchmarks.gold_answers import join_operators_as_answer
from eai.tasks.operator_task import TransitionTask


def gold_answer(task: TransitionTask) -> str:
    """Return the data set's gold operators as an answer."""
    return join_operators_as_answer(task.domain.operators[name].write_pddl for name in task.operators)
