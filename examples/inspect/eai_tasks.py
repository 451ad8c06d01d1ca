"""The suites of both households as Inspect tasks in one file.

``inspect list tasks`` and Inspect's register of evaluations read files instead of entry points. Each task is
``eai/<name>`` with the same arguments.
"""

from __future__ import annotations

from typing import Any

from inspect_ai import Task, task

from eai.run.registry import TASKS


@task
def virtualhome_goal_interpretation(**arguments: Any) -> Task:
    """Goal interpretation in VirtualHome."""
    return TASKS["virtualhome_goal_interpretation"](**arguments)


@task
def virtualhome_subgoal_decomposition(**arguments: Any) -> Task:
    """Subgoal decomposition in VirtualHome."""
    return TASKS["virtualhome_subgoal_decomposition"](**arguments)


@task
def virtualhome_action_sequencing(**arguments: Any) -> Task:
    """Action sequencing in VirtualHome."""
    return TASKS["virtualhome_action_sequencing"](**arguments)


@task
def virtualhome_transition_modeling(**arguments: Any) -> Task:
    """Transition modeling in VirtualHome."""
    return TASKS["virtualhome_transition_modeling"](**arguments)


@task
def behavior_goal_interpretation(**arguments: Any) -> Task:
    """Goal interpretation in BEHAVIOR."""
    return TASKS["behavior_goal_interpretation"](**arguments)


@task
def behavior_subgoal_decomposition(**arguments: Any) -> Task:
    """Subgoal decomposition in BEHAVIOR."""
    return TASKS["behavior_subgoal_decomposition"](**arguments)


@task
def behavior_action_sequencing(**arguments: Any) -> Task:
    """Action sequencing in BEHAVIOR."""
    return TASKS["behavior_action_sequencing"](**arguments)


@task
def behavior_transition_modeling(**arguments: Any) -> Task:
    """Transition modeling in BEHAVIOR."""
    return TASKS["behavior_transition_modeling"](**arguments)
